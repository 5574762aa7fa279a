"""What a scene has for a modality beside vibration."""

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
    """``values`` of objects where they are not the modality's defaults; ``forms``: functions, as in a scene file, of those whose author
    chose another than the default; ``emitters`` in the order of their names. ``enabled`` False: its author has switched it off."""

    modality: Modality
    values: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    forms: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    emitters: tuple[Emitter, ...] = ()
    enabled: bool = True

    @property
    def is_empty(self) -> bool:
        """True where nothing is said but that it is off."""
        return not (self.values or self.forms or self.emitters or self.enabled)

    def felt_in(self, scene: HapticScene) -> Felt:
        """What the listeners of ``scene`` feel of it, through the contacts that it lists. Raises ValueError as `feel` does."""
        names = sorted(item.name for item in scene.objects)
        contacts = ContactSet.from_contacts(scene.contacts, {name: number for number, name in enumerate(names)})
        return feel(self.modality, names, self.values, contacts, self.emitters, scene.listeners, scene.settings, self.forms)
