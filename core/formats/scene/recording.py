"""A scene over time: the changes from frame to frame, and tracing them again."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence, Set
from dataclasses import field, replace
from typing import TypeVar

import numpy as np

from ...arrays import FloatArray, IntArray
from ...contacts.contact_set import ContactSet
from ...contacts.settings import Body
from ...contacts.shapes import pose_matrix
from ...events.frame import EXACT_FRAMES, Frame
from ...events.one_shots import Shot
from ...frozen import frozen
from ...render.frame_result import FrameResult
from ...render.renderer import SAMPLE_RATE
from ...scene.functions import ModulationFunction
from ...scene.values import (
    Contact,
    HapticObject,
    HapticScene,
    Listener,
    Pose,
    Source,
    SourceKind,
    Trigger,
    Vector,
)
from ...tracer import Tracer

Pair = tuple[str, str]
Item = TypeVar("Item")
Value = TypeVar("Value")

DIGITS = 15
"""Decimals of recorded values that gains depend on, so that a recording reproduces the gains to 12
digits, also where waves spread from a radius of millimetres on."""


PoseRow = tuple[float, float, float, float, float, float, float]
PosedObject = tuple[HapticObject, PoseRow | None]

STILL_RATE = 30
"""Frame rate at which a scene without frames is traced."""

POSE_DIGITS = 5
"""Decimals of recorded poses. Contacts are recorded as well: gains depend on poses only by how far
these lie beside the middles of bodies."""
PER_UNIT = 10**POSE_DIGITS


class Poses(Mapping[str, PoseRow]):
    """Poses by object, stored as integers (n, 7) in units of 1e-5: a seventh of the memory of a
    dictionary of tuples."""

    __slots__ = "_rows", "names", "ticks"

    def __init__(self, names: tuple[str, ...], ticks: IntArray) -> None:
        self.names, self.ticks = names, ticks
        self._rows: dict[str, int] | None = None

    @classmethod
    def of(cls, poses: Mapping[str, PoseRow]) -> Poses:
        """The poses rounded to 1e-5."""
        if isinstance(poses, Poses):
            return poses
        values = np.array(list(poses.values()), dtype=np.float64).reshape(-1, 7)
        return cls(tuple(poses), np.rint(values * PER_UNIT).astype(np.int64))

    def __getitem__(self, name: str) -> PoseRow:
        if self._rows is None:
            self._rows = {key: row for row, key in enumerate(self.names)}
        return pose_row(self.ticks[self._rows[name]])

    def __iter__(self) -> Iterator[str]:
        return iter(self.names)

    def __len__(self) -> int:
        return len(self.names)


def pose_row(ticks: IntArray) -> PoseRow:
    """A pose from its integers."""
    a, b, c, d, e, f, g = (ticks / PER_UNIT).tolist()
    return a, b, c, d, e, f, g


@frozen
class RecordedFrame:
    """The changes since the frame before; the changes since the scene itself for the first frame.

    poses: by object, position x, y, z and rotation w, x, y, z. properties: (kappa, rho) by object.
    functions: propagation function by object. amplitudes and source_positions: by source; a source
    of two objects has a position on each. listener_positions and gains: by listener. contacts: all
    contacts of every pair of objects whose contacts changed. parted: pairs that no longer touch.
    sources: those that begin, or begin again (`Source.rubs`); a temporary source ends when its
    signal has ended. removed_objects, removed_listeners: names of those that disappear, with all
    sources and listeners on them. objects, listeners: those that appear, after the removals.
    """

    number: int
    poses: Mapping[str, PoseRow] = field(default_factory=dict)
    properties: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    functions: Mapping[str, ModulationFunction] = field(default_factory=dict)
    amplitudes: Mapping[str, float] = field(default_factory=dict)
    source_positions: Mapping[str, tuple[Vector, ...]] = field(default_factory=dict)
    listener_positions: Mapping[str, Vector] = field(default_factory=dict)
    gains: Mapping[str, float] = field(default_factory=dict)
    contacts: tuple[Contact, ...] = ()
    parted: tuple[Pair, ...] = ()
    sources: tuple[Source, ...] = ()
    objects: tuple[HapticObject, ...] = ()
    listeners: tuple[Listener, ...] = ()
    removed_objects: tuple[str, ...] = ()
    removed_listeners: tuple[str, ...] = ()


CHANGES: Mapping[str, tuple[str, tuple[str, ...]]] = {
    "poses": ("objects", ("pose",)),
    "properties": ("objects", ("kappa", "rho")),
    "functions": ("objects", ("propagation",)),
    "amplitudes": ("sources", ("amplitude",)),
    "source_positions": ("sources", ("position", "second_position")),
    "listener_positions": ("listeners", ("position",)),
    "gains": ("listeners", ("gain",)),
}
"""By field of `RecordedFrame`: which items change, and what of them. Of several values the first
ones may stand alone."""


@frozen
class Recording:
    """``frames`` in ascending order; in frames without an entry nothing changed. Frame
    ``frame_start`` is at 0 seconds."""

    frame_rate: float
    frame_start: int
    frames: tuple[RecordedFrame, ...]

    @classmethod
    def still(cls, seconds: float) -> Recording:
        """Frames, about `STILL_RATE` a second, in which nothing changes."""
        count = max(round(seconds * STILL_RATE), 1)
        return cls(count / seconds, 0, (RecordedFrame(0), RecordedFrame(count)))

    def time_of(self, frame: int) -> float:
        """The time of a frame [s]."""
        return (frame - self.frame_start) / self.frame_rate


def pair_of(contact: Contact) -> Pair:
    """The two objects in alphabetical order."""
    return _sorted_pair(*contact.objects)


def states(
    scene: HapticScene, recording: Recording, late: Callable[[], Mapping[str, float]] = dict
) -> Iterator[tuple[int, HapticScene]]:
    """Every frame number from the first to the last recorded, with the scene in it: its active
    sources and its contacts. ``late``: delay of a source at the listeners [s], by name."""
    state = SceneState(scene)
    frames = iter(recording.frames)
    change = next(frames, None)
    number = change.number if change else 0
    while change is not None:
        if change.number == number:
            state.apply(change)
            change = next(frames, None)
        state.end_sources(recording.time_of(number) - 1 / recording.frame_rate, late())
        yield number, state.scene()
        number += 1


def _is_over(source: Source, time: float) -> bool:
    """Whether a temporary source has ended before ``time``, up to rounding."""
    return (
        source.kind is SourceKind.TEMPORARY
        and source.onset + source.emitted.duration <= time + 1e-9
    )


def by_pair(contacts: Sequence[Contact]) -> dict[Pair, tuple[Contact, ...]]:
    """The contacts of each pair of objects."""
    result: dict[Pair, tuple[Contact, ...]] = {}
    for contact in contacts:
        result[pair_of(contact)] = (*result.get(pair_of(contact), ()), contact)
    return result


class SceneState:
    """The current state of a changing scene: its items by name, and the contacts by pairs of
    objects."""

    def __init__(self, scene: HapticScene) -> None:
        self._scene = scene
        self.objects = {item.name: item for item in scene.objects}
        self.sources = {item.name: item for item in scene.sources}
        self.listeners = {item.name: item for item in scene.listeners}
        self.contacts = by_pair(scene.contacts)

    def scene(self) -> HapticScene:
        """The current scene."""
        return replace(
            self._scene,
            objects=tuple(self.objects.values()),
            sources=tuple(self.sources.values()),
            listeners=tuple(self.listeners.values()),
            contacts=tuple(contact for touching in self.contacts.values() for contact in touching),
        )

    def end_sources(self, time: float, late: Mapping[str, float]) -> None:
        """Remove the temporary sources that have ended before ``time``."""
        for name in [
            name
            for name, item in self.sources.items()
            if _is_over(item, time - late.get(name, 0.0))
        ]:
            del self.sources[name]

    def apply(self, change: RecordedFrame) -> None:
        """Apply the changes of the next recorded frame."""
        self.remove(change)
        for kind in ("objects", "sources", "listeners"):
            getattr(self, kind).update((item.name, item) for item in getattr(change, kind))
        for key, (kind, fields) in CHANGES.items():
            items = getattr(self, kind)
            for name, value in getattr(change, key).items():
                if key == "poses":
                    value = Pose(value[:3], value[3:])
                values = value if len(fields) > 1 else (value,)
                items[name] = replace(items[name], **dict(zip(fields, values, strict=False)))
        self.contacts.update(by_pair(change.contacts))

    def remove(self, change: RecordedFrame) -> None:
        """Remove the contacts of pairs that part, objects with all sources, listeners and contacts
        on them, and listeners."""
        for pair in change.parted:
            self.contacts.pop(pair, None)
        for name in change.removed_listeners:
            self.listeners.pop(name, None)
        gone = set(change.removed_objects)
        if gone:
            self.objects = {name: item for name, item in self.objects.items() if name not in gone}
            self.sources = {
                name: item for name, item in self.sources.items() if not is_on(item, gone)
            }
            self.listeners = {
                name: item for name, item in self.listeners.items() if item.object not in gone
            }
            self.contacts = {
                pair: touching for pair, touching in self.contacts.items() if gone.isdisjoint(pair)
            }


def is_on(source: Source, objects: Set[str]) -> bool:
    """Whether a source is on one of the objects."""
    return source.object in objects or source.second_object in objects


def traced(
    scene: HapticScene, recording: Recording, sample_rate: float = SAMPLE_RATE
) -> Iterator[FrameResult]:
    """Trace every frame with the recorded contacts; if there are none at all, contacts are found
    from shapes and poses."""
    tracer = Tracer(scene.rules, sample_rate=sample_rate)
    detect = not scene.contacts and not any(
        frame.contacts or frame.parted for frame in recording.frames
    )
    for number, state in states(scene, recording, lambda: tracer.collisions.delays):
        frame = frame_of(state, number, recording.time_of(number), detect)
        yield tracer.step(replace(frame, exact=number % EXACT_FRAMES == 0))


def frame_of(scene: HapticScene, number: int, time: float, detect: bool) -> Frame:
    """The tracer's input for a scene at ``time``; ``detect``: find contacts from shapes and
    poses."""
    frame = Frame(number, time, scene.objects, scene.sources, scene.listeners, scene.settings)
    if detect:
        shaped = [item for item in scene.objects if item.shape is not None]
        bodies = tuple(Body.of(item, item.shape) for item in shaped)
        transforms = np.array(
            [pose_matrix(item.pose or Pose()) for item in shaped], dtype=np.float64
        ).reshape(-1, 4, 4)
        return replace(frame, bodies=bodies, transforms=transforms)
    index = {name: i for i, name in enumerate(sorted(item.name for item in scene.objects))}
    return replace(frame, contacts=ContactSet.from_contacts(scene.contacts, index))


class SceneRecorder:
    """Records the changes of a scene frame by frame.

    A persistent source that disappears while its object stays gets the amplitude 0 until it is
    back. The triggers of a source are written as the times at which it played.
    """

    def __init__(self, frame_rate: float, frame_start: int) -> None:
        self._rate, self._start = frame_rate, frame_start
        self._objects: dict[str, PosedObject] = {}
        self._sources: dict[str, Source] = {}
        self._listeners: dict[str, Listener] = {}
        self._contacts: dict[Pair, bytes] = {}
        self._functions: dict[ModulationFunction, int] = {}
        self._first = HapticScene()
        self._frames: list[RecordedFrame] = []
        self._shots: set[Shot] = set()

    def add(
        self,
        number: int,
        objects: Sequence[HapticObject],
        sources: Sequence[Source],
        listeners: Sequence[Listener],
        contacts: ContactSet,
        names: Sequence[str],
        shots: Collection[Shot] = (),
    ) -> None:
        """Add a frame. Raises ValueError unless ``number`` ascends.

        Args:
            number: of the frame.
            objects: of the scene, with their poses in it.
            sources: of the scene, without impacts.
            listeners: of the scene.
            contacts: of the frame.
            names: of the objects by their numbers in ``contacts``.
            shots: of sources with triggers.
        """
        self._shots.update(shots)
        if self._frames and number <= self._frames[-1].number:
            raise ValueError(
                f"number: frame {number} does not come after frame {self._frames[-1].number}"
            )
        begun = not self._frames
        numbers = [
            self._functions.setdefault(function, len(self._functions))
            for function in contacts.transmissions
        ]
        rows = _rows(contacts, np.array(numbers, dtype=np.float64))
        touching = _touching(contacts, rows, names)
        changed = [pair for pair, rows in touching.items() if self._contacts.get(pair) != rows]
        parted = tuple(pair for pair in self._contacts if pair not in touching)
        moved = _contacts_of(contacts, rows, names, set(changed))
        self._contacts = touching
        gone = self._removed_objects(objects)
        removed = tuple(sorted(self._listeners.keys() - {item.name for item in listeners}))
        appearing = tuple(item for item in objects if item.name not in self._objects)
        hearing = tuple(_placed(item) for item in listeners if item.name not in self._listeners)
        of_objects = self._changed_objects(objects)
        of_listeners = self._changed_listeners(listeners)
        new, of_sources = self._changed_sources(sources)
        if begun:
            self._first = HapticScene(
                objects=appearing, contacts=moved, sources=new, listeners=hearing
            )
            self._frames.append(RecordedFrame(number))
        else:
            change = RecordedFrame(
                number,
                *of_objects,
                *of_sources,
                *of_listeners,
                moved,
                parted,
                new,
                appearing,
                hearing,
                gone,
                removed,
            )
            self._frames.append(change)

    def scene(self) -> HapticScene:
        """The scene in the first frame."""
        return replace(self._first, sources=self._timed(self._first.sources))

    def recording(self) -> Recording:
        """The changes since the first frame."""
        return Recording(
            self._rate,
            self._start,
            tuple(replace(frame, sources=self._timed(frame.sources)) for frame in self._frames),
        )

    def _timed(self, sources: tuple[Source, ...]) -> tuple[Source, ...]:
        """The sources, with the times of their shots for triggers."""
        return tuple(
            item if item.triggers is None else replace(item, triggers=self._times(item.name))
            for item in sources
        )

    def _times(self, source: str) -> tuple[Trigger, ...]:
        shots = sorted((s.onset, s.strength) for s in self._shots if s.source == source)
        if not shots:
            return ()
        onsets, strengths = zip(*shots, strict=True)
        return (Trigger(onsets, strengths if min(strengths) < 1 else ()),)

    def _removed_objects(self, objects: Sequence[HapticObject]) -> tuple[str, ...]:
        """The names of objects that have disappeared; the sources on them are removed, so that they
        can begin again."""
        gone = self._objects.keys() - {item.name for item in objects}
        for name in [name for name, item in self._sources.items() if gone and is_on(item, gone)]:
            del self._sources[name]
        return tuple(sorted(gone))

    def _changed_objects(
        self, objects: Sequence[HapticObject]
    ) -> tuple[
        Mapping[str, PoseRow], dict[str, tuple[float, float]], dict[str, ModulationFunction]
    ]:
        """Poses, (kappa, rho) and functions of the objects that existed before."""
        before = self._objects
        self._objects = {item.name: _posed(item, before.get(item.name)) for item in objects}
        rows = _changed(self._objects, before, lambda known: known[1])
        poses = Poses.of({name: row for name, row in rows.items() if row is not None})
        properties = _changed(self._objects, before, lambda known: (known[0].kappa, known[0].rho))
        return (
            poses,
            properties,
            _changed(self._objects, before, lambda known: known[0].propagation),
        )

    def _changed_sources(
        self, sources: Sequence[Source]
    ) -> tuple[tuple[Source, ...], tuple[dict[str, float], dict[str, tuple[Vector, ...]]]]:
        """The sources that begin; amplitudes and positions of the others."""
        new: list[Source] = []
        amplitudes: dict[str, float] = {}
        positions: dict[str, tuple[Vector, ...]] = {}
        for item in sources:
            second = None if item.second_position is None else _rounded(item.second_position)
            rounded = replace(item, position=_rounded(item.position), second_position=second)
            before = self._sources.get(item.name)
            self._sources[item.name] = rounded
            if before is None or (rounded.rubs and rounded.onset != before.onset):
                new.append(rounded)
                continue
            if rounded.amplitude != before.amplitude:
                amplitudes[item.name] = rounded.amplitude
            if (rounded.position, rounded.second_position) != (
                before.position,
                before.second_position,
            ):
                positions[item.name] = (
                    (rounded.position,) if second is None else (rounded.position, second)
                )
        for name in self._sources.keys() - {item.name for item in sources}:
            gone = self._sources[name]
            if gone.kind is SourceKind.PERSISTENT and gone.amplitude:
                amplitudes[name] = 0.0
                self._sources[name] = replace(gone, amplitude=0.0)
        return tuple(new), (dict(sorted(amplitudes.items())), positions)

    def _changed_listeners(
        self, listeners: Sequence[Listener]
    ) -> tuple[dict[str, Vector], dict[str, float]]:
        """Positions and gains of the listeners that existed before."""
        before = self._listeners
        self._listeners = {item.name: _placed(item) for item in listeners}
        positions = _changed(self._listeners, before, lambda item: item.position)
        return positions, _changed(self._listeners, before, lambda item: item.gain)


def _changed(
    now: Mapping[str, Item], before: Mapping[str, Item], value: Callable[[Item], Value]
) -> dict[str, Value]:
    """The changed values of items that existed before, by name."""
    changed = {}
    for name, item in now.items():
        earlier = before.get(name, item)
        if earlier is not item and (known := value(item)) != value(earlier):
            changed[name] = known
    return changed


def _posed(item: HapticObject, before: PosedObject | None) -> PosedObject:
    """An object and its rounded pose; ``before`` if that is of the same object."""
    if before is not None and before[0] is item:
        return before
    return item, None if item.pose is None else _pose_row(item.pose)


def _placed(item: Listener) -> Listener:
    """A listener at its rounded position."""
    return replace(item, position=_rounded(item.position))


def _rounded(vector: Sequence[float]) -> Vector:
    x, y, z = (round(component, DIGITS) for component in vector)
    return x, y, z


def _pose_row(pose: Pose) -> PoseRow:
    a, b, c, d, e, f, g = (
        round(component, POSE_DIGITS) for component in (*pose.position, *pose.rotation)
    )
    return a, b, c, d, e, f, g


_SCALARS = ("distance", "area", "weight")


def _rows(contacts: ContactSet, numbers: FloatArray) -> FloatArray:
    """One row per contact: positions, normal, distance, area, weight, all rounded, and the index of
    its transmission function."""
    parts = (
        contacts.positions.reshape(-1, 6),
        contacts.normal,
        *(getattr(contacts, name) for name in _SCALARS),
    )
    # Adding 0 turns -0 into 0.
    return np.column_stack(
        [np.round(np.column_stack(parts), DIGITS) + 0.0, numbers[contacts.transmission]]
    )


def _touching(contacts: ContactSet, rows: FloatArray, names: Sequence[str]) -> dict[Pair, bytes]:
    """The contacts of each pair of objects as bytes, which are quick to compare."""
    result: dict[Pair, bytes] = {}
    for (first, second), row in zip(contacts.pairs.tolist(), rows, strict=True):
        pair = _sorted_pair(names[first], names[second])
        result[pair] = result.get(pair, b"") + row.tobytes()
    return result


def _contacts_of(
    contacts: ContactSet, every_row: FloatArray, names: Sequence[str], pairs: set[Pair]
) -> tuple[Contact, ...]:
    chosen = [
        i
        for i, (a, b) in enumerate(contacts.pairs.tolist())
        if _sorted_pair(names[a], names[b]) in pairs
    ]
    rows = every_row[chosen]
    part = replace(
        contacts,
        pairs=contacts.pairs[chosen],
        positions=rows[:, :6].reshape(-1, 2, 3),
        normal=rows[:, 6:9],
        depth=np.maximum(-rows[:, 9], 0.0),
        transmission=contacts.transmission[chosen],
        **dict(zip(_SCALARS, rows.T[9:12], strict=True)),
    )
    return part.to_contacts(names)


def _sorted_pair(first: str, second: str) -> Pair:
    return (first, second) if first <= second else (second, first)
