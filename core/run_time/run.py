"""A run of a scene: each step takes poses and answers levels, impacts and samples."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray, IntArray
from ..contacts.authored import AuthoredContacts
from ..contacts.contact_set import ContactSet
from ..contacts.impacts import Impact
from ..contacts.settings import Body
from ..contacts.shapes import pose_matrix, rotation_matrix
from ..diagnosis.doubts import doubts
from ..events.frame import Frame
from ..formats.io.schema import validate
from ..formats.scene.values_json import read_listener, read_object, read_source
from ..render.history import History
from ..render.renderer import checked_rate
from ..scene.references import PlacedError, require_known, require_new
from ..scene.rules import ContactSettings
from ..scene.values import (
    HapticObject,
    HapticScene,
    Listener,
    Pose,
    Settings,
    Source,
    Trigger,
)
from ..tracer import Tracer
from .given import contact_set, plain, read_contacts, read_impacts
from .step import Step, answer

LONGEST_STEP = 0.25
"""Duration of a step from which on the run begins anew: without impacts, from silence [s]."""

_FASTEST = 100.0
"""Speed [m/s] above which an object has been set elsewhere, unless it was half as fast before."""

LONGEST_RUN = 1e6
"""Seconds since its first step from which on a run begins anew: signals go on for so long."""

_SHORTEST, _FARTHEST = 1e-12, 1e9
"""Length above which a quaternion is a rotation, and the largest coordinate [m]."""

Item = TypeVar("Item", Source, Listener)

Numbers = Sequence[float] | NDArray[np.floating] | NDArray[np.integer]
"""Three numbers of a position in the world [m], or seven of a pose."""


class Run:
    """A scene in time. Objects keep their poses, and sources what they play, until a step says
    otherwise.

    Sources and listeners move rigidly with their objects. Contacts are found from shapes, except
    between objects for which the scene lists contacts and which have not moved.

    ``warnings``: what in the scene is probably not meant, in sentences.

    The examples go on with a run of the ``scene`` of `Scene`: a drill and a hand on a bench, 1 m
    apart.
    """

    def __init__(self, scene: HapticScene, sample_rate: float) -> None:
        self.settings: Settings = scene.settings
        self.rules: ContactSettings = scene.rules
        self.sample_rate: float = checked_rate(sample_rate)
        self.warnings: tuple[str, ...] = tuple(doubts(scene))
        self._solids: list[tuple[HapticObject, Body]] = []
        # Of all sources, then of all listeners: the rows of their objects, and their positions in
        # the frames of these (n, 3).
        self._anchors: tuple[IntArray, FloatArray] | None = None
        self._waiting: Frame | None = None  # of the step that was followed last, if not answered
        self._set_objects(
            scene.objects, [pose_matrix(item.pose or Pose()) for item in scene.objects]
        )
        self._moved: set[str] = set()
        self._anew: set[str] = (
            set()
        )  # objects that came, or were set elsewhere, since the last step
        self._fast: set[str] = set()  # objects at more than half of `_FASTEST` in the last step
        self._listed = scene.contacts
        self._silent: set[str] = set()  # sources that do not play
        self._amplitudes: dict[str, float] = {}
        self._asked: list[str] = []  # sources to be played once from the last step on
        self._played: dict[str, list[float]] = {}  # when they were, since the run began
        # By kind and name, in the frame of the object.
        self._places: dict[tuple[str, str], FloatArray] = {}
        self._sources: dict[str, Source] = {}
        self._listeners: dict[str, Listener] = {}
        for source in scene.sources:
            self._place("source", source)
        for listener in scene.listeners:
            self._place("listener", listener)
        self._tracer = Tracer(self.rules, sample_rate, lazy=True, paths=True)
        self._history = History()
        self._time: float | None = None  # of the step that was followed last
        self._first = 0.0  # time of the step in which the run began
        self._step = 0

    def __repr__(self) -> str:
        time = "not begun" if self._time is None else f"at {self._time:.6g} s"
        return (
            f"<Run of {len(self.objects)} objects, {len(self.sources)} sources, "
            f"{len(self.listeners)} listeners, {time}>"
        )

    @property
    def objects(self) -> tuple[str, ...]:
        """The names of the objects."""
        return tuple(self._objects)

    @property
    def sources(self) -> tuple[str, ...]:
        """The names of the sources."""
        return tuple(self._sources)

    @property
    def listeners(self) -> tuple[str, ...]:
        """The names of the listeners, in the order of the rows of samples."""
        return tuple(self._listeners)

    @property
    def is_calibrated(self) -> bool:
        """Whether the devices of all listeners are calibrated, so that no margin is assumed."""
        return all(item.device is not None for item in self._listeners.values())

    @property
    def body_parts(self) -> dict[str, str]:
        """The body part of each listener, "" for none."""
        return {name: item.body_part for name, item in self._listeners.items()}

    def step(
        self,
        time: float,
        poses: Mapping[str, Numbers] | None = None,
        sources: Mapping[str, Mapping[str, Any]] | None = None,
        *,
        contacts: Sequence[Mapping[str, Any]] | None = None,
        impacts: Sequence[Mapping[str, Any]] | None = None,
        source_positions: Mapping[str, Numbers] | None = None,
        listener_positions: Mapping[str, Numbers] | None = None,
    ) -> Step:
        """Go on to ``time`` [s]. Where it goes back, or on by more than `LONGEST_STEP`, the run
        begins anew.

        Args:
            time: seconds of the caller's clock.
            poses: of objects that have moved: x, y, z [m], then the rotation as a quaternion w, x,
                y, z of any length but 0.
            sources: ``playing`` and ``amplitude`` of sources, from now on.
            contacts: all that touch now, as in a scene file; none are searched for then.
            impacts: since the last step, as `read_impacts` takes them; none are searched for then.
            source_positions, listener_positions: world positions that replace those on the objects,
            for this step.

        Raises:
            ValueError: names the key where a value is not valid; the run is as it was then.

        >>> first = run.step(0.0)
        >>> raised = run.step(0.125, {"bench": [0, 0, 2, 1, 0, 0, 0]})
        >>> raised.levels["hand"].gains, raised.block.shape  # 1/8 s of samples at 8 kHz
        ({'drill': 0.75}, (1, 1000))
        """
        self.follow(
            time,
            poses,
            sources,
            contacts=contacts,
            impacts=impacts,
            source_positions=source_positions,
            listener_positions=listener_positions,
        )
        return self.answer()

    def continues(self, time: float) -> bool:
        """Whether a step at ``time`` [s] continues the last one; otherwise the run begins anew.

        >>> run.step(0.0).time, run.continues(0.25), run.continues(0.3)
        (0.0, True, False)
        """
        return (
            self._time is not None
            and 0 < time - self._time <= LONGEST_STEP
            and time - self._first < LONGEST_RUN
        )

    def follow(
        self,
        time: float,
        poses: Mapping[str, Numbers] | None = None,
        sources: Mapping[str, Mapping[str, Any]] | None = None,
        *,
        contacts: Sequence[Mapping[str, Any]] | None = None,
        impacts: Sequence[Mapping[str, Any]] | None = None,
        source_positions: Mapping[str, Numbers] | None = None,
        listener_positions: Mapping[str, Numbers] | None = None,
    ) -> None:
        """Go on to ``time`` as `step` does, without an answer: `answer` gives that to the step that
        was followed last, with the impacts of all since the last one; where the run begins anew,
        what was not answered is dropped.

        >>> run.follow(0.25)
        >>> run.follow(0.375)
        >>> run.answer().time
        0.375
        """
        is_number = isinstance(time, int | float | np.floating)
        if not (is_number and math.isfinite(time)) or time == self._time:
            raise PlacedError(
                ("time",),
                f"must be a finite number, and other than that of the last step, got {time!r}",
            )
        moved = self._checked_poses(poses or {})
        self._check_sources(sources or {})
        self._check_positions("source", self._sources, source_positions or {})
        self._check_positions("listener", self._listeners, listener_positions or {})
        given = None if contacts is None else read_contacts(contacts, self._objects)
        begun, first = time, time
        if self._time is not None and self.continues(time):
            begun, first = self._time, self._first
        struck = (
            None
            if impacts is None
            else read_impacts(impacts, self._row, self._objects, self.rules, (begun, time), first)
        )
        if not self.continues(time):
            self._first, self._time = time, None
            self._played.clear()
        for name in self._asked:
            earliest = begun - first - self._sources[name].emitted.duration
            known = [one for one in self._played.get(name, ()) if one > earliest]
            self._played[name] = [*known, begun - first]
        self._asked.clear()
        self._move(list(poses or {}), moved, math.inf if self._time is None else time - self._time)
        for name, form in (sources or {}).items():
            self._play(name, form)
        if self._waiting is None:
            self._step += 1
        elif self._waiting.continuous:
            self._tracer.pass_by(self._waiting)
        else:  # samples begin there
            self._tracer.step(self._waiting)
        self._waiting = self._frame(
            time, given, struck, source_positions or {}, listener_positions or {}
        )
        self._time = time
        self._anew.clear()

    def answer(self) -> Step:
        """The answer to the step that was followed last. Raises ValueError if it was given already.

        >>> run.follow(0.0)
        >>> run.answer().levels["hand"].gains
        {'drill': 0.75}
        """
        frame, self._waiting = self._waiting, None
        if frame is None or self._time is None:
            raise ValueError("no step was followed since the last answer")
        result = self._tracer.step(frame)
        self._history.feed(result)
        return answer(result, self._history, frame.objects, self._time)

    def play(self, source: str) -> None:
        """Play the signal of a source with triggers once, from the last step on. Raises
        ValueError.

        >>> run.add(source={"name": "knock", "object": "bench", "position": [0, 0, 0],
        ...                 "triggers": [], "signal": {"signal": "impulse"}})
        >>> run.play("knock")
        """
        require_known(source, self._sources, "source", ("source",))
        if self._sources[source].triggers is None:
            raise PlacedError(
                ("source",),
                f"{source!r} plays all the time; only a source with triggers plays once",
            )
        self._asked.append(source)

    def stop(self) -> None:
        """Fall silent and forget contacts, velocities and impacts; objects keep their poses.

        >>> run.stop()
        """
        self._tracer.reset()
        self._history = History()
        self._time = self._waiting = None

    def add(
        self,
        object: Mapping[str, Any] | None = None,
        source: Mapping[str, Any] | None = None,
        listener: Mapping[str, Any] | None = None,
    ) -> None:
        """Add an object, a source or a listener, as in a scene file. Raises ValueError, also where
        the name exists.

        >>> run.add(listener={"name": "foot", "object": "bench", "position": [3, 0, 0],
        ...               "radius": 0})
        >>> run.step(0.0).levels["foot"].gains
        {'drill': 0.25}
        """
        object, source, listener = _valid("add", object=object, source=source, listener=listener)
        if object is not None:
            item = read_object(object, ("object",))
            require_new(item.name, self._objects, "object", ("object", "name"))
            pose = pose_matrix(item.pose or Pose())
            self._anew.add(item.name)
            self._set_objects((*self._objects.values(), item), [*self._poses_listed(), pose])
        if source is not None:
            self._add("source", read_source(source, ("source",)), self._sources)
        if listener is not None:
            self._add("listener", read_listener(listener, ("listener",)), self._listeners)

    def remove(
        self, object: str | None = None, source: str | None = None, listener: str | None = None
    ) -> None:
        """Remove an object, with the sources and listeners on it, a source or a listener, by name.
        Raises ValueError.

        >>> run.remove(object="bench")
        >>> run.objects, run.sources, run.listeners
        ((), (), ())
        """
        if object is not None:
            require_known(object, self._objects, "object", ("object",))
            poses = dict(zip(self._objects, self._poses_listed(), strict=True))
            del poses[object]
            self._listed = tuple(
                contact for contact in self._listed if object not in contact.objects
            )
            self._sources = {
                name: item
                for name, item in self._sources.items()
                if object not in (item.object, item.second_object)
            }
            self._listeners = {
                name: item for name, item in self._listeners.items() if item.object != object
            }
            self._set_objects([self._objects[name] for name in poses], [*poses.values()])
        if source is not None:
            require_known(source, self._sources, "source", ("source",))
            del self._sources[source]
        if listener is not None:
            require_known(listener, self._listeners, "listener", ("listener",))
            del self._listeners[listener]
        self._anchors = None

    def replace(
        self,
        object: Mapping[str, Any] | None = None,
        source: Mapping[str, Any] | None = None,
        listener: Mapping[str, Any] | None = None,
    ) -> None:
        """Replace an object, a source or a listener by one of the same name. Raises ValueError,
        also where there is none.

        >>> run.replace(listener={"name": "hand", "object": "bench", "position": [2, 0, 0],
        ...                   "radius": 0})
        >>> run.step(0.0).levels["hand"].gains
        {'drill': 0.5}
        """
        object, source, listener = _valid(
            "replace", object=object, source=source, listener=listener
        )
        if object is not None:
            item = read_object(object, ("object",))
            require_known(item.name, self._objects, "object", ("object", "name"))
            if item.pose is not None:
                self._poses[self._row[item.name]] = pose_matrix(item.pose)
                self._anew.add(item.name)
            self._moved.add(item.name)
            self._set_objects((self._objects | {item.name: item}).values(), self._poses_listed())
        if source is not None:
            require_known(source["name"], self._sources, "source", ("source", "name"))
            self._place("source", read_source(source, ("source",)))
        if listener is not None:
            require_known(listener["name"], self._listeners, "listener", ("listener", "name"))
            self._place("listener", read_listener(listener, ("listener",)))

    def _add(self, kind: str, item: Source | Listener, known: Mapping[str, Any]) -> None:
        require_new(item.name, known, kind, (kind, "name"))
        self._silent.discard(item.name)  # one of this name may have been removed
        self._place(kind, item)

    def _place(self, kind: str, item: Source | Listener) -> None:
        """Add or replace a source or listener, with its position in the frame of its object."""
        require_known(item.object, self._objects, "object", (kind, "object"))
        pose = self._poses[self._row[item.object]]
        self._places[kind, item.name] = pose[:3, :3].T @ (np.array(item.position) - pose[:3, 3])
        self._anchors = None
        if isinstance(item, Source):
            self._sources[item.name] = item
            self._amplitudes.pop(item.name, None)  # it brings its own
            self._played.pop(item.name, None)
        else:
            self._listeners[item.name] = item

    def _poses_listed(self) -> FloatArray:
        """The poses (n, 4, 4) in the order of `objects`."""
        return self._poses[[self._row[name] for name in self._objects]]

    def _set_objects(
        self, objects: Iterable[HapticObject], poses: FloatArray | Sequence[FloatArray]
    ) -> None:
        """Take over a changed list of objects with their poses (n, 4, 4). Rows are those of objects
        with a shape, then those of the others."""
        if self._waiting is not None:
            raise ValueError("objects can't change before `answer` is asked for what was followed")
        self._objects = {item.name: item for item in objects}
        listed = list(self._objects.values())
        order = sorted(range(len(listed)), key=lambda k: listed[k].shape is None)
        self._frame_objects = tuple(listed[k] for k in order)
        self._row = {item.name: row for row, item in enumerate(self._frame_objects)}
        self._poses = np.array(poses, dtype=np.float64).reshape(-1, 4, 4)[order]
        known = {id(item): body for item, body in self._solids}
        self._solids = [
            (item, known.get(id(item)) or Body.of(item, item.shape))
            for item in self._frame_objects
            if item.shape is not None
        ]
        self._bodies = tuple(body for _, body in self._solids)
        self._authored: tuple[frozenset[str], AuthoredContacts] | None = None
        self._anchors = None

    def _checked_poses(self, poses: Mapping[str, Numbers]) -> FloatArray:
        """Poses of objects as an array (n, 7), with unit quaternions."""
        if not poses.keys() <= self._row.keys():
            for name in poses:
                require_known(name, self._row, "object", ("poses", name))
        try:
            moved = np.array([*poses.values()], dtype=np.float64).reshape(len(poses), 7)
            if not (np.abs(moved) <= _FARTHEST).all():
                raise ValueError
            length = np.sqrt(sum(part * part for part in moved[:, 3:].T))
            if not (length > _SHORTEST).all():
                raise ValueError
        except (TypeError, ValueError):
            raise PlacedError(
                ("poses", _faulty(poses)),
                f"expected x, y, z, qw, qx, qy, qz: up to {_FARTHEST:g}, and a rotation",
            ) from None
        moved[:, 3:] /= length[:, None]
        return moved

    def _move(self, names: Sequence[str], moved: FloatArray, duration: float) -> None:
        """Set the poses (n, 7) of the named objects, ``duration`` seconds after the last step."""
        rows = np.array([self._row[name] for name in names], dtype=np.int64)
        way = moved[:, :3] - self._poses[rows, :3, 3]
        travel = np.sqrt((way * way).sum(axis=1))
        far = abs(duration) * _FASTEST
        fast = (travel > far / 2).nonzero()[0].tolist()
        self._anew |= {names[k] for k in fast if travel[k] > far} - self._fast
        self._fast = {names[k] for k in fast}
        self._poses[rows, :3, :3] = rotation_matrix(moved[:, 3:])
        self._poses[rows, :3, 3] = moved[:, :3]
        if self._listed:
            self._moved.update(names)

    def _check_sources(self, sources: Mapping[str, Mapping[str, Any]]) -> None:
        """Raise PlacedError unless each form says what a source of the run shall do."""
        for name, form in sources.items():
            require_known(name, self._sources, "source", ("sources", name))
            if not isinstance(form, Mapping):
                raise PlacedError(
                    ("sources", name),
                    f"expected {{'playing': ..., 'amplitude': ...}}, got {form!r}",
                )
            for key, value in form.items():
                if key != "playing" and not (
                    key == "amplitude" and isinstance(value, int | float) and 0 <= value <= 1
                ):
                    raise PlacedError(
                        ("sources", name, key),
                        "expected playing: true or false, or amplitude: 0 to 1",
                    )

    def _check_positions(
        self, kind: str, known: Mapping[str, Any], positions: Mapping[str, Numbers]
    ) -> None:
        """Raise PlacedError unless all are three numbers for something known of this kind."""
        for name, place in positions.items():
            where = f"{kind}_positions", name
            require_known(name, known, kind, where)
            try:
                valid = len(place) == 3 and all(abs(value) <= _FARTHEST for value in place)
            except TypeError:
                valid = False
            if not valid:
                raise PlacedError(where, f"expected x, y, z: up to {_FARTHEST:g}")

    def _play(self, name: str, form: Mapping[str, Any]) -> None:
        if "playing" in form:
            (self._silent.discard if form["playing"] else self._silent.add)(name)
        if "amplitude" in form:
            self._amplitudes[name] = float(form["amplitude"])

    def _frame(
        self,
        time: float,
        given: ContactSet | None,
        struck: tuple[Impact, ...] | None,
        source_positions: Mapping[str, Numbers],
        listener_positions: Mapping[str, Numbers],
    ) -> Frame:
        """The frame of the tracer that ends at ``time``.

        Args:
            time: its end [s].
            given: the contacts; None where they are found.
            struck: the impacts since the last step; None where they are found.
            source_positions: world positions by name that replace those on the objects [m].
            listener_positions: new positions of listeners by name [m].
        """
        if given is None and not self._bodies:
            given = contact_set(self._listed, self._objects)
        places = self._places_now()
        sources = []
        for source in _moved(self._sources, places, source_positions):
            amplitude = (
                0.0
                if source.name in self._silent
                else self._amplitudes.get(source.name, source.amplitude)
            )
            played = self._played.get(source.name)
            if amplitude != source.amplitude:
                source = replace(source, amplitude=amplitude)
            if played:
                once = Trigger(tuple(played))
                source = replace(source, triggers=(*(source.triggers or ()), once))
            sources.append(source)
        return Frame(
            number=self._step,
            anew=frozenset(self._anew),
            time=time - self._first,
            objects=self._frame_objects,
            sources=tuple(sources),
            listeners=tuple(_moved(self._listeners, places[len(sources) :], listener_positions)),
            settings=self.settings,
            bodies=self._bodies if given is None else (),
            transforms=self._poses.copy(),
            contacts=given,
            continuous=self._time is not None,
            authored=self._contacts_listed() if given is None else None,
            struck=struck,
        )

    def _places_now(self) -> list[list[float]]:
        """The positions of all sources, then of all listeners, on their objects."""
        if self._anchors is None:
            items: list[Source | Listener] = [*self._sources.values(), *self._listeners.values()]
            keys = [("source", name) for name in self._sources]
            keys += [("listener", name) for name in self._listeners]
            self._anchors = (
                np.array([self._row[item.object] for item in items], dtype=np.int64),
                np.array([self._places[key] for key in keys]).reshape(-1, 3),
            )
        rows, places = self._anchors
        poses = self._poses[rows]
        now = np.einsum("nij,nj->ni", poses[:, :3, :3], places) + poses[:, :3, 3]
        found: list[list[float]] = now.tolist()
        return found

    def _contacts_listed(self) -> AuthoredContacts | None:
        """The contacts that the scene lists between objects that have not moved, or have no
        shape."""
        if not self._listed:
            return None
        settled = frozenset(self._objects) - self._moved
        if self._authored is None or self._authored[0] != settled:
            shapeless = {item.name for item in self._frame_objects if item.shape is None}
            kept = [
                item
                for item in self._listed
                if settled.issuperset(item.objects) or not shapeless.isdisjoint(item.objects)
            ]
            self._authored = settled, AuthoredContacts.of(self._objects, settled, kept)
        return self._authored[1]


def _moved(
    items: Mapping[str, Item], places: Sequence[Sequence[float]], given: Mapping[str, Numbers]
) -> list[Item]:
    """Sources or listeners at the first of the ``places``, or at their ``given`` positions."""
    return [
        item.moved(given.get(item.name, place))
        for item, place in zip(items.values(), places, strict=False)
    ]


def _valid(message: str, **parts: Mapping[str, Any] | None) -> list[dict[str, Any] | None]:
    """The given parts with plain values. Raises FormatError unless they are those of a valid
    message of the server."""
    given: dict[str, dict[str, Any] | None] = plain(parts)
    validate(
        {key: value for key, value in given.items() if value is not None},
        f"run-time-1#{message}",
        message,
    )
    return list(given.values())


def _faulty(poses: Mapping[str, Numbers]) -> str:
    """The first object whose pose is not one."""
    for name, pose in poses.items():
        try:
            if (
                len(pose) != 7
                or not all(abs(value) <= _FARTHEST for value in pose)
                or math.hypot(*pose[3:]) <= _SHORTEST
            ):
                return name
        except TypeError:
            return name
    return next(iter(poses))
