"""Temporary sources of impacts: templates that play once, attached to the two bodies that hit each
other."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from ..arrays import FloatArray
from ..contacts.impacts import Impact
from ..contacts.tracker import FrameContacts
from ..frozen import frozen
from ..scene.rules import ContactSettings, ImpactTemplates
from ..scene.values import HapticObject, Source, SourceKind
from ..signals import DEFAULT_IMPACT, Signal, impact_template
from .frame import Frame


@frozen
class ActiveImpact:
    """An impact and its source, with the template that plays; ``local``: the source's position in
    the frame of either body."""

    impact: Impact
    source: Source
    local: tuple[FloatArray, FloatArray]

    @classmethod
    def of(
        cls, impact: Impact, bodies: tuple[str, str], local: tuple[FloatArray, FloatArray]
    ) -> ActiveImpact:
        """An impact of ``bodies``, by name, with the default signal."""
        first, second = bodies
        source = Source(
            name=f"impact of {first} and {second} at {impact.time:.4f} s",
            object=first,
            position=impact.positions[0],
            second_object=second,
            second_position=impact.positions[1],
            amplitude=impact.amplitude,
            kind=SourceKind.TEMPORARY,
            signal=DEFAULT_IMPACT,
            onset=impact.time,
        )
        return cls(impact, source, local)

    @property
    def bodies(self) -> tuple[str, str]:
        """The names of the bodies."""
        return self.source.object, self.source.second_object or ""

    def between(self, objects: tuple[int, int]) -> ActiveImpact:
        """This impact with these numbers of its bodies."""
        if objects == self.impact.objects:
            return self
        return replace(self, impact=replace(self.impact, objects=objects))

    def playing(
        self, objects: Mapping[str, HapticObject], settings: ContactSettings
    ) -> ActiveImpact:
        """This impact with the signal and the amplitude that rules give it between ``objects``, by
        name."""
        a, b = (objects[name] for name in self.bodies)
        rule = settings.impact_rule((a.name, a.material), (b.name, b.material))
        template = rule.template
        if not isinstance(template, Signal):
            known = (
                template is ImpactTemplates.BY_MATERIAL and a.impact_material and b.impact_material
            )
            template = (
                impact_template(a.impact_material, b.impact_material) if known else DEFAULT_IMPACT
            )
        signal, amplitude = rule.played(
            template, self.impact.amplitude, self.bodies, self.impact.time
        )
        if signal == self.source.signal and amplitude == self.source.amplitude:
            return self
        return replace(self, source=replace(self.source, signal=signal, amplitude=amplitude))


class Impacts:
    """The active impacts.

    Attributes:
        active: those that sound.
        began: those that began in the last frame.
        delays: longest delay of each source at the listeners [s], by name.
    """

    def __init__(self) -> None:
        self.clear()

    def clear(self) -> None:
        """Drop all impacts."""
        self.active: tuple[ActiveImpact, ...] = ()
        self.began: tuple[Impact, ...] = ()
        self.delays: Mapping[str, float] = {}

    def snapshot(self) -> tuple[ActiveImpact, ...]:
        """What `restore` needs of the last frame."""
        return self.active

    def restore(
        self, kept: Sequence[ActiveImpact], start: float, frame: Frame, settings: ContactSettings
    ) -> None:
        """Return to the impacts ``kept`` of a ``frame`` that begins at ``start`` [s]."""
        self.clear()
        if settings.impacts:
            objects = {item.name: item for item in frame.objects}
            self.active = tuple(item.playing(objects, settings) for item in kept)
            self.began = tuple(item.impact for item in kept if item.impact.time > start)

    def follow(
        self, frame: Frame, since: float | None, found: FrameContacts, settings: ContactSettings
    ) -> tuple[Source, ...]:
        """The sources in a ``frame``, with those of the impacts ``found`` in it; templates end that
        have ended, with their delays at listeners, by ``since`` [s], the time of the frame before
        (None without one)."""
        transforms = frame.transforms
        if transforms is None:
            self.clear()
            self.began = found.impacts
            return ()
        number = {name: row for row, name in enumerate(frame.names)} if self.active else {}
        self.active = tuple(
            item.between((number[first], number[second]))
            for item in self.active
            for first, second in (item.bodies,)
            if first in number and second in number and (since is None or self._end(item) > since)
        )
        new = found.impacts if settings.impacts else ()
        if new or since is not None:
            self.began = new
        if new:
            names = frame.names
            objects = {item.name: item for item in frame.objects}
            sounding = {item.source.name for item in self.active}
            self.active += _named_apart(
                sounding,
                (
                    ActiveImpact.of(
                        impact,
                        (names[first], names[second]),
                        (
                            _to_body(transforms[first], impact.positions[0]),
                            _to_body(transforms[second], impact.positions[1]),
                        ),
                    ).playing(objects, settings)
                    for impact in new
                    for first, second in (impact.objects,)
                ),
            )
        return self._sources(transforms)

    def _end(self, item: ActiveImpact) -> float:
        source = item.source
        return item.impact.time + source.emitted.duration + self.delays.get(source.name, 0.0)

    def _sources(self, transforms: FloatArray) -> tuple[Source, ...]:
        """The sources, each at its place on both bodies."""
        if not self.active:
            return ()
        local = np.array([item.local for item in self.active])
        placed = transforms[np.array([item.impact.objects for item in self.active])]
        places = np.einsum("kbij,kbj->kbi", placed[..., :3, :3], local) + placed[..., :3, 3]
        return tuple(
            item.source.moved(*place)
            for item, place in zip(self.active, places.tolist(), strict=True)
        )


def _named_apart(names: set[str], items: Iterable[ActiveImpact]) -> tuple[ActiveImpact, ...]:
    """Impacts with other ``names`` than those that sound: an engine may report several blows of
    two bodies at one time."""
    found = []
    for item in items:
        name = item.source.name
        while name in names:
            name += "+"
        names.add(name)
        if name != item.source.name:
            item = replace(item, source=replace(item.source, name=name))
        found.append(item)
    return tuple(found)


def _to_body(transform: FloatArray, position: Sequence[float]) -> FloatArray:
    """A world position in the frame of a rigid transform (4, 4)."""
    return transform[:3, :3].T @ (np.asarray(position) - transform[:3, 3])
