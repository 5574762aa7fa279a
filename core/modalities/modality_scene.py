"""Properties of a scene for a modality other than vibration."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from ..contacts.contact_set import ContactSet
from ..scene.values import HapticScene
from .modality import Modality
from .propagation import Emitter, Felt, feel


@dataclass(frozen=True, slots=True)
class ModalityScene:
    """``values`` of objects that differ from the modality's defaults; ``forms``: functions that differ from the default, as in a scene
    file; ``emitters`` in the order of their names. ``enabled`` False: its author has switched it off."""

    modality: Modality
    values: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    forms: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    emitters: tuple[Emitter, ...] = ()
    enabled: bool = True

    @property
    def is_empty(self) -> bool:
        """True if it has no content, apart from being switched off."""
        return not (self.values or self.forms or self.emitters or self.enabled)

    def felt_in(self, scene: HapticScene) -> Felt:
        """Propagate the modality to the listeners of ``scene`` through its listed contacts. Raises ValueError as `feel` does."""
        names = sorted(item.name for item in scene.objects)
        contacts = ContactSet.from_contacts(scene.contacts, {name: number for number, name in enumerate(names)})
        return feel(self.modality, names, self.values, contacts, self.emitters, scene.listeners, scene.settings, self.forms)
