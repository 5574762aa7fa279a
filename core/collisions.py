"""Collision detection of one frame: contacts between objects by their numbers in the graph,
impacts, and temporary sources."""

from __future__ import annotations

import copy
import math
from collections.abc import Mapping, Sequence
from dataclasses import field, replace
from functools import cached_property
from time import perf_counter
from typing import Any

import numpy as np

from .arrays import FloatArray, IntArray
from .contacts.authored import AuthoredContacts
from .contacts.contact_set import ContactSet
from .contacts.impact_sources import MOST_FRAMES, FrameImpacts, ImpactSources, Templates
from .contacts.impacts import Impact
from .contacts.one_shots import OneShots, Shot
from .contacts.rubbing import SlidingAndRolling
from .contacts.settings import Body, ContactSettings
from .contacts.tracker import ContactTracker, Endpoints
from .contacts.transmissions import TransmissionRules
from .frozen import frozen
from .graph.haptic_graph import ObjectTable, large_patches
from .graph.object_frames import ObjectFrames, local_bounds
from .message import Message
from .scene.choices import Mode, Strategy
from .scene.functions import ModulationFunction
from .scene.impact_rule import ImpactRule
from .scene.rule_table import RuleTable
from .scene.rules import ImpactTemplates
from .scene.values import HapticObject, Listener, Settings, Source, TriggerKind
from .unchanged import Unchanged

_ON_PATHS = (Strategy.AUTO, Strategy.BEST_PATH)
"""Strategies whose gains depend on nothing beside the paths from sources to listeners."""

EXACT_FRAMES = 32
"""Frames whose number is a multiple of this are `Frame.exact`: later frames can be traced from
there with bit-identical results."""


@frozen
class Frame:
    """The state of a scene at one frame.

    ``time`` [s]; the tracer renders the samples from the previous frame's time to this one's, so
    that an impact between the two is placed at its time. ``continuous``: this frame follows the one
    traced last; otherwise contact history, velocities and active signals are dropped. Either bodies
    are given, with rigid world ``transforms`` (n, 4, 4) of ``bodies``, which are ``objects`` in the
    same order; or ``contacts``, which number the objects by their sorted names. ``authored``
    contacts replace detected ones. ``restore``: where this frame is not continuous, it has the
    impacts stored when it was last traced as a continuous one, see `CollisionDetector`. ``exact``:
    contacts and gains are recomputed also after motions below the tolerance of rest. ``duration``
    [s]: of a frame that is not continuous, for triggers at given times. ``heard``: its samples are
    rendered. ``struck``: the impacts since the previous frame, which number the bodies (or the
    ``objects`` where ``contacts`` are given, ``transforms`` being theirs); None: they are found.
    ``anew``: names of bodies that appeared or were set elsewhere since the previous frame, without
    a motion in between: they make no impact in this frame.
    """

    number: int
    time: float
    objects: tuple[HapticObject, ...]
    sources: tuple[Source, ...]
    listeners: tuple[Listener, ...]
    settings: Settings = field(default_factory=Settings)
    bodies: tuple[Body, ...] = ()
    transforms: FloatArray | None = None
    contacts: ContactSet | None = None
    continuous: bool = True
    authored: AuthoredContacts | None = None
    restore: bool = False
    exact: bool = False
    duration: float = 0.0
    heard: bool = True
    struck: tuple[Impact, ...] | None = None
    anew: frozenset[str] = frozenset()

    @property
    def moving(self) -> tuple[str, ...]:
        """The names of what has ``transforms``."""
        return tuple(item.name for item in (self.bodies if self.contacts is None else self.objects))


@frozen
class Collisions:
    """Collisions of one frame.

    Attributes:
        contacts: between objects, by their numbers in the table.
        frames: frames of reference of the objects, None if propagation does not need them.
        impacts: that began in this frame.
        sources: temporary sources of triggers, active impacts, and of sliding and rolling.
        statistics, milliseconds: work and time by stage.
        warnings: about objects.
        start: time at which the frame begins [s], known if its impacts are restored.
        shots: the active one-shots, which are among the sources.
    """

    contacts: ContactSet
    frames: ObjectFrames | None = None
    impacts: tuple[Impact, ...] = ()
    sources: tuple[Source, ...] = ()
    statistics: Mapping[str, int | float] = field(default_factory=dict)
    milliseconds: Mapping[str, float] = field(default_factory=dict)
    warnings: tuple[Message, ...] = ()
    start: float | None = None
    shots: tuple[Shot, ...] = ()


class CollisionDetector:
    """Detects the collisions of consecutive frames.

    ``lazy``: contacts are detected only in heaps of bodies that hold a listener and a sound, and
    with ``paths`` only where a path between these may lead; gains and impacts are unaffected.

    Impacts need two consecutive frames. They are stored for at most `MOST_FRAMES` frames, and
    restored in a frame with ``restore``, which was reached by a jump on the timeline or is traced a
    second time after an edit: modes, gains, materials and strategies are thus compared on the same
    impact, sliding and rolling. All stored impacts are dropped when bodies, shapes, masses,
    motions, or rules of contacts and impacts change, when a struck body has moved, and by
    `forget_impacts`, which is called after edits of animation and physics.
    """

    def __init__(self, settings: ContactSettings, lazy: bool, paths: bool = False) -> None:
        self.settings = settings
        self.lazy, self.paths = lazy, paths
        self._sources = ImpactSources()
        self._rubbing = SlidingAndRolling(EXACT_FRAMES)
        self._shots = OneShots()
        self._tracker: ContactTracker | None = None
        self._interrupted: ContactTracker | None = None  # see `take_over`
        self._numbering = Unchanged(_Numbering)
        self._transmissions = Unchanged(_transmissions)
        self._numbered = Unchanged(_numbered)
        self._tracked = Unchanged(_tracked)
        self._without_materials = Unchanged(_without_materials)
        self._stored: dict[int, FrameImpacts] = {}
        self._rules: tuple[tuple[Body, ...], ContactSettings] | None = None  # of the stored impacts
        self._last: Frame | None = None

    @property
    def has_stored_impacts(self) -> bool:
        """Whether impacts, sliding or rolling of any frame are stored."""
        return bool(self._stored)

    def impacts_of(self, number: int) -> FrameImpacts | None:
        """Return the stored impacts of a frame."""
        return self._stored.get(number)

    def restore_impacts(self, number: int, bodies: tuple[Body, ...], kept: FrameImpacts) -> None:
        """Replace all stored impacts by those of one frame of ``bodies``."""
        self._rules = self._rules_of(bodies)
        self._stored = {number: kept}

    def _rules_of(self, bodies: tuple[Body, ...]) -> tuple[tuple[Body, ...], ContactSettings]:
        if not self.settings.impact_table.rows:  # then materials make no impact
            bodies = self._without_materials(bodies)
        return bodies, self._tracked(self.settings)

    def forget_impacts(self) -> None:
        """Drop all stored impacts."""
        self._stored.clear()
        self._last = None

    def take_over(self, interrupted: CollisionDetector) -> None:
        """Take over the settings, the stored impacts and what is known of shapes of an interrupted
        detector, but not its contacts."""
        self.settings, self.lazy = interrupted.settings, interrupted.lazy
        self._stored, self._rules = interrupted._stored, interrupted._rules
        self._interrupted = interrupted._tracker or interrupted._interrupted

    def is_retrace(self, frame: Frame) -> bool:
        """Whether ``frame`` is the one that was traced last, with the same poses and shapes: an
        edit has changed sources, listeners, materials or settings at most."""
        if (
            self._last is None
            or self._tracker is None
            or frame.transforms is None
            or self._tracker.settings != self._tracked(self.settings)
        ):
            return False
        last = self._last
        return (
            (last.number, last.time, last.bodies) == (frame.number, frame.time, frame.bodies)
            and last.transforms is not None
            and np.array_equal(last.transforms, frame.transforms)
        )

    def history(self) -> bytes:
        """The state of contacts and impacts that later frames depend on."""
        arrays = () if self._tracker is None else self._tracker.history()
        sources = repr((self._sources.names, self._shots.sounding)) + self._rubbing.history()
        return b"".join(
            [sources.encode(), *(np.ascontiguousarray(array).tobytes() for array in arrays)]
        )

    def reset(self) -> None:
        """Drop contact history, velocities and active impacts."""
        self._sources.clear()
        self._rubbing.clear()
        self._shots.clear()
        if self._tracker is not None:
            self._tracker.reset()

    @property
    def delays(self) -> Mapping[str, float]:
        """Largest delay of each source at the listeners [s], by name."""
        return self._shots.delays

    def set_delays(self, delays: Mapping[str, float]) -> None:
        """Extend temporary sources by their largest delays at the listeners [s], given by name."""
        self._sources.delays = self._shots.delays = delays

    def detect(
        self, frame: Frame, table: ObjectTable, previous: float | None, retrace: bool = False
    ) -> Collisions:
        """Return the collisions of a frame.

        Args:
            frame: the frame.
            table: numbers its objects.
            previous: time of the frame before it [s], None without one.
            retrace: the frame `is_retrace`. Its contacts are detected from scratch by a copy of the
                tracker, so that later frames are not affected, and its impacts are restored.
        """
        if frame.contacts is not None or not frame.bodies or frame.transforms is None:
            return self._given(frame, table, previous)
        begun = perf_counter()
        tracker = self._follow(frame.bodies, frame.anew)
        numbering = self._numbering(frame.bodies, table)
        self._sources.renumber(numbering.row)
        kept = None  # the stored impacts of this frame, where they are restored
        if retrace:
            tracker = copy.copy(tracker)
            tracker.reset()
        elif previous is not None:
            self._sources.end_before(previous)
        if retrace or (frame.restore and previous is None):
            self._sources.clear()
            kept = self._restorable(frame.number, frame.transforms)
        restored = (
            ()
            if kept is None or not self.settings.impacts
            else self._sources.restore(kept, self._templates(frame))
        )
        rules = self._transmissions(self.settings.transmission_table, table)
        hits = _has_hit_triggers(frame.sources)
        endpoints = self._endpoints(frame, numbering.row, rules.uses_force or hits)
        searched = frame.struck is None and (self.settings.impacts or hits)
        found = tracker.update(
            frame.time, frame.transforms, endpoints, frame.continuous, searched, frame.exact
        )
        contacts = self._numbered(found.contacts, numbering, rules, frame.authored)
        broad = found.statistics.broad_seconds
        struck = found.impacts if frame.struck is None else frame.struck
        impacts = struck if self.settings.impacts else ()
        if impacts:
            self._sources.add(impacts, frame.moving, frame.transforms, self._templates(frame))
        shots = self._one_shots(frame, previous, kept, struck, retrace)
        rubbing: tuple[Source, ...] = ()
        if self.settings.textures.rows:
            if not retrace:
                self._rubbing.follow(
                    frame.number,
                    None if previous is None else (previous, frame.time),
                    frame.bodies,
                    found.contacts,
                    frame.transforms,
                    numbering.middles,
                    self.settings,
                    frame.anew,
                )
            if kept is not None and kept.rubbed is not None:
                self._rubbing.restore(kept.rubbed)
            rubbing = self._rubbing.sources(frame.bodies, self.settings.textures)
        else:
            self._rubbing.clear()
        if previous is not None and not retrace:
            self._store(
                frame,
                self._sources.snapshot(
                    previous, frame.transforms, self._shots.sounding, self._rubbing.snapshot
                ),
            )
        self._last = frame
        return Collisions(
            contacts=contacts,
            frames=numbering.frames(frame, table, contacts),
            impacts=impacts or restored,
            sources=shots + rubbing + self._sources.sources(frame.transforms),
            statistics={
                "candidate_pairs": found.statistics.candidates,
                "contact_queries": found.statistics.queries,
                "queries_avoided": found.statistics.avoided,
            },
            milliseconds={"broad": 1000 * broad, "narrow": 1000 * (perf_counter() - begun - broad)},
            warnings=found.warnings,
            start=None if kept is None else kept.start,
            shots=self._shots.sounding,
        )

    def _given(self, frame: Frame, table: ObjectTable, previous: float | None) -> Collisions:
        """Return the collisions of a frame whose contacts are given."""
        contacts = ContactSet.empty() if frame.contacts is None else frame.contacts
        frames = (
            ObjectFrames.of_objects(frame.objects, frame.transforms)
            if _asks_for_frames(frame.settings, contacts, table)
            else None
        )
        struck = frame.struck or ()
        sources = self._one_shots(frame, previous, None, struck)
        if frame.transforms is None or previous is None:
            self._sources.clear()
        if frame.transforms is not None:
            self._sources.renumber({name: row for row, name in enumerate(frame.moving)})
            self._sources.end_before(frame.time if previous is None else previous)
            self._sources.add(struck, frame.moving, frame.transforms, self._templates(frame))
            sources += self._sources.sources(frame.transforms)
        return Collisions(contacts, frames, struck, sources, shots=self._shots.sounding)

    def _one_shots(
        self,
        frame: Frame,
        previous: float | None,
        kept: FrameImpacts | None,
        impacts: Sequence[Impact],
        retrace: bool = False,
    ) -> tuple[Source, ...]:
        """The temporary sources of the triggers since ``previous`` [s], or of the ``kept`` ones.

        Args:
            frame: the frame.
            previous: time of the frame before [s], None without one.
            kept: the stored impacts of the frame, None where its triggers are detected.
            impacts: since the frame before.
            retrace: the frame `is_retrace`: nothing is detected, later frames continue from its
                first trace.
        """
        sources = [source for source in frame.sources if source.triggers]
        if not sources:
            self._shots.clear()
            return ()
        if retrace or kept is not None:
            self._shots.restore(() if kept is None else kept.shots, sources)
        if not retrace:
            names = frame.moving
            hits = [
                ((names[a], names[b]), impact.time, impact.amplitude)
                for impact in impacts
                for a, b in (impact.objects,)
            ]
            self._shots.follow(sources, previous, frame.time, _places(frame), hits)
        start = next(
            time
            for time in (
                None if kept is None else kept.start,
                previous,
                frame.time - frame.duration,
            )
            if time is not None
        )
        return self._shots.sources(sources, start, frame.time, frame.objects, self.settings)

    def _restorable(self, number: int, transforms: FloatArray) -> FrameImpacts | None:
        """Return the stored impacts of a frame; all are dropped if a struck body has moved."""
        kept = self._stored.get(number)
        if kept is not None and not kept.bodies_unmoved(transforms):
            self.forget_impacts()
            kept = None
        return kept

    def _store(self, frame: Frame, kept: FrameImpacts | None) -> None:
        self._stored.pop(frame.number, None)
        if kept is not None:
            self._rules = self._rules_of(frame.bodies)
            self._stored[frame.number] = kept
            if len(self._stored) > MOST_FRAMES:
                del self._stored[next(iter(self._stored))]

    def _templates(self, frame: Frame) -> Templates:
        """Return the templates of the impacts of a frame."""
        return Templates(self.settings, {item.name: item for item in frame.objects})

    def _follow(self, bodies: tuple[Body, ...], anew: frozenset[str]) -> ContactTracker:
        """Return a tracker of ``bodies``: the current one if the settings are the same."""
        tracker = self._tracker
        settings = self._tracked(self.settings)
        if self._stored and self._rules != self._rules_of(bodies):
            self.forget_impacts()
        if tracker is None or tracker.settings != settings:
            before, self._interrupted = tracker or self._interrupted, None
            tracker = self._tracker = ContactTracker(bodies, settings, before)
            self._sources.clear()
            self._rubbing.clear()
        elif anew or tracker.bodies != bodies:
            tracker.replace_bodies(bodies, anew)
        tracker.bodies = bodies  # which are the sooner known to be the same in the next frame
        return tracker

    def _endpoints(
        self, frame: Frame, row: Mapping[Any, int], every_contact: bool
    ) -> Endpoints | None:
        """Return where signals begin and end, to which the detection of contacts is restricted:
        bodies, numbered by name in ``row``, with active sources and with listeners, none in a mode
        without propagation through contacts. None if all contacts are needed: for a frame that is
        not lazy, and for ``every_contact``."""
        # Forces (each depends on all others), triggers and textures use contacts without a signal.
        if (
            not self.lazy
            or frame.authored is not None
            or every_contact
            or self.settings.textures.rows
        ):
            return None
        heard, sounding = np.zeros((2, len(frame.bodies)), dtype=np.bool_)
        if frame.settings.mode in (Mode.HT, Mode.SD):
            names = [
                name
                for source in frame.sources
                if source.amplitude > 0
                for name in (source.object, source.second_object)
            ]
            heard[
                [row[listener.object] for listener in frame.listeners if listener.object in row]
            ] = True
            sounding[[row[name] for name in names if name in row]] = True
            sounding[self._sources.bodies] = True
            for impact in frame.struck or ():
                sounding[list(impact.objects)] = True
        return Endpoints(heard, sounding, self.paths and frame.settings.strategy in _ON_PATHS)


def _tracked(settings: ContactSettings) -> ContactSettings:
    """The settings that affect the detection of contacts and impacts."""
    rows = tuple(
        replace(row, value=ImpactRule(limits=row.value.limits))
        for row in settings.impact_table.rows
    )
    return replace(
        settings,
        impacts=True,
        templates=ImpactTemplates.PLAIN,
        impact_table=RuleTable(rows),
        transmission_table=RuleTable(),
        textures=RuleTable(),
    )


def _without_materials(bodies: tuple[Body, ...]) -> tuple[Body, ...]:
    return tuple(replace(body, material="") if body.material else body for body in bodies)


def _transmissions(table: RuleTable[ModulationFunction], objects: ObjectTable) -> TransmissionRules:
    """The functions of contacts between objects by a table of rules."""
    return TransmissionRules(table, [(item.name, item.material) for item in objects.objects])


def _numbered(
    found: ContactSet,
    numbering: _Numbering,
    rules: TransmissionRules,
    authored: AuthoredContacts | None,
) -> ContactSet:
    """Contacts between objects instead of bodies, the authored ones in place of those ``found``."""
    contacts = rules.over(replace(found, pairs=numbering.objects[found.pairs]))
    return contacts if authored is None else authored.over(contacts)


class _Numbering:
    """Numbering of bodies and of the objects of a table.

    ``row``: the number of a body by name. ``objects`` (n,): the number of each body's object.
    """

    def __init__(self, bodies: tuple[Body, ...], table: ObjectTable) -> None:
        self.bodies = bodies
        self._count = len(table.names)
        self.row = {body.name: number for number, body in enumerate(bodies)}
        index = table.index()
        self.objects: IntArray = np.array([index[body.name] for body in bodies], dtype=np.int64)

    def frames(self, frame: Frame, table: ObjectTable, contacts: ContactSet) -> ObjectFrames | None:
        """The frames of reference of the objects that something asks for, None if nothing does:
        gains for all that touch, and the axes of listeners with an extent, as it depends on how
        they are turned where on them vibration arrives."""
        transforms = frame.transforms
        assert transforms is not None
        frames = ObjectFrames.unknown(self._count)
        turned = [self.row[item.object] for item in frame.listeners if item.radius > 0]
        if turned:
            frames = frames.turned(self.objects[turned], transforms[turned])
        if not _asks_for_frames(frame.settings, contacts, table, self.sizes):
            return frames if turned else None
        touching = np.zeros(self._count, dtype=np.bool_)
        touching[contacts.pairs] = True
        rows = touching[self.objects].nonzero()[0]
        return frames.placed(self.objects[rows], self.bounds[rows], transforms[rows])

    @cached_property
    def sizes(self) -> FloatArray:
        """The sizes (n, 3) of the objects' bounding boxes [m], NaN without a body."""
        sizes = np.full((self._count, 3), math.nan)
        sizes[self.objects] = np.ptp(self.bounds, axis=1)
        return sizes

    @cached_property
    def middles(self) -> FloatArray:
        """The centres (n, 3) of the bodies' local bounding boxes."""
        return np.asarray(self.bounds.mean(axis=1))

    @cached_property
    def bounds(self) -> FloatArray:
        """The bodies' local bounding boxes (n, 2, 3)."""
        return local_bounds([body.shape for body in self.bodies])


def _places(frame: Frame) -> dict[str, FloatArray]:
    """The positions (3,) of the objects' origins, by name."""
    if frame.transforms is not None:
        return dict(zip(frame.moving, frame.transforms[:, :3, 3], strict=True))
    return {
        item.name: np.array(item.pose.position) for item in frame.objects if item.pose is not None
    }


def _has_hit_triggers(sources: Sequence[Source]) -> bool:
    """Whether impacts of objects trigger any of the sources."""
    return any(
        trigger.on is TriggerKind.HIT for source in sources for trigger in source.triggers or ()
    )


def _asks_for_frames(
    settings: Settings, contacts: ContactSet, table: ObjectTable, sizes: FloatArray | None = None
) -> bool:
    """Whether gains depend on where the objects lie. ``sizes`` (n, 3): of their boxes [m], if they
    are known."""
    return (
        settings.strategy is Strategy.ENERGY_BALANCE
        or any(function.uses_force for function in contacts.transmissions)
        or bool(len(large_patches(table, contacts, sizes)))
    )
