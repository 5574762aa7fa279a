"""Propagation of modalities: one value per listener and frame."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import field, replace

import numpy as np

from ..arrays import FloatArray
from ..contacts.contact_set import ContactSet
from ..forms import Form
from ..frozen import frozen
from ..graph.haptic_graph import ObjectTable, build_graph
from ..propagation import objects_on, propagate
from ..scene.functions import ALL_FUNCTIONS, Constant, ModulationFunction, function_from_dict
from ..scene.values import Extent, HapticObject, HapticScene, Listener, Settings, Source
from .modality import Modality


@frozen
class Emitter:
    """A source of a modality: its object, its position (metres, world) and its value in the
    modality's unit."""

    name: str
    object: str
    position: tuple[float, float, float]
    value: float


@frozen
class Felt:
    """``gains`` (s, l) of the emitters at the listeners, ``values`` (l,) in the modality's unit,
    and the objects of each best path."""

    modality: Modality
    emitters: tuple[Emitter, ...]
    listeners: tuple[str, ...]
    gains: FloatArray
    values: FloatArray
    paths: Mapping[tuple[int, int], tuple[str, ...]]


def propagation_function(
    modality: Modality, values: Mapping[str, float], form: Form | None = None
) -> ModulationFunction:
    """The function of an object: ``form`` as in a scene file, None for the modality's default.

    An object's ``values`` are the parameters that ``form`` does not give. Raises ValueError that
    names the key.
    """
    name = (form or {}).get("function", modality.default_function)
    functions = {key: ALL_FUNCTIONS[key] for key in modality.functions}
    function = functions.get(name)
    known = (
        set()
        if function is None
        else {key for key in values if key in function.__dataclass_fields__}
    )
    return function_from_dict(
        {"function": name, **{key: values[key] for key in known}, **(form or {})}, functions
    )


def _with_transmission(
    modality: Modality,
    names: Sequence[str],
    values: Mapping[str, Mapping[str, float]],
    contacts: ContactSet,
) -> ContactSet:
    """The contacts with the modality's gains. Both directions through a contact have the geometric
    mean of the two gains, so that the product of a round trip is exact."""
    gains = [
        math.sqrt(
            modality.transmission(values[names[first]])
            * modality.transmission(values[names[second]])
        )
        for first, second in contacts.pairs.tolist()
    ]
    known = {gain: number for number, gain in enumerate(dict.fromkeys(gains))}
    functions = tuple(Constant(gain_value=gain) for gain in known)
    numbers = np.array([known[gain] for gain in gains], dtype=np.int64)
    return replace(
        contacts, transmission=numbers, transmissions=functions or contacts.transmissions
    )


@frozen
class ModalityScene:
    """``values`` of objects that differ from the modality's defaults; ``forms``: functions that
    differ from the default, as in a scene file; ``emitters`` in the order of their names.
    ``enabled`` False: its author has switched it off."""

    modality: Modality
    values: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    forms: Mapping[str, Form] = field(default_factory=dict)
    emitters: tuple[Emitter, ...] = ()
    enabled: bool = True

    @property
    def is_empty(self) -> bool:
        """True if it is switched off and has no content."""
        return not (self.values or self.forms or self.emitters or self.enabled)

    def felt_in(self, scene: HapticScene) -> Felt:
        """Propagate the modality to the listeners of ``scene`` through its listed contacts. Raises
        ValueError as `felt` does."""
        names = sorted(item.name for item in scene.objects)
        contacts = ContactSet.from_contacts(
            scene.contacts, {name: number for number, name in enumerate(names)}
        )
        return self.felt(names, contacts, scene.listeners, scene.settings)

    def felt(
        self,
        names: Sequence[str],
        contacts: ContactSet,
        listeners: Sequence[Listener],
        settings: Settings,
    ) -> Felt:
        """Propagate the modality through the contacts that the tracer found.

        names: objects in the (sorted) order of the numbers in ``contacts``. Raises ValueError with
        the reason.
        """
        modality = self.modality
        own = {name: {**modality.defaults(), **self.values.get(name, {})} for name in names}
        objects = [
            HapticObject(
                name, 0.0, 1.0, propagation_function(modality, own[name], self.forms.get(name))
            )
            for name in names
        ]
        sources = tuple(
            Source(emitter.name, emitter.object, emitter.position) for emitter in self.emitters
        )
        table = ObjectTable.of(objects, settings.epsilon)
        middles = tuple(replace(listener, extent=Extent.NONE) for listener in listeners)
        graph = build_graph(
            table, _with_transmission(modality, names, own, contacts), sources, middles
        )
        found = propagate(
            graph,
            replace(settings, strategy=modality.strategy, threshold=0.0, max_connections=None),
        )
        strengths = np.array([emitter.value for emitter in self.emitters], dtype=np.float64)
        paths = {pair: objects_on(graph, nodes) for pair, nodes in found.best_path.items()}
        return Felt(
            modality,
            self.emitters,
            tuple(listener.name for listener in listeners),
            found.gain,
            strengths @ found.gain,
            paths,
        )
