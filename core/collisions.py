"""Detection of what happens in a frame: contacts between objects by their numbers in the graph,
then each kind of event, with its temporary sources."""

from __future__ import annotations

import copy
import math
from collections.abc import Mapping
from dataclasses import field, replace
from functools import cached_property
from time import perf_counter
from typing import Any

import numpy as np

from .arrays import FloatArray, IntArray
from .contacts.authored import AuthoredContacts
from .contacts.contact_set import ContactSet
from .contacts.impacts import Impact
from .contacts.settings import Body, ContactSettings
from .contacts.tracker import ContactStatistics, ContactTracker, Endpoints, FrameContacts
from .contacts.transmissions import TransmissionRules
from .events.events import Events
from .events.frame import Frame
from .events.one_shots import Shot
from .events.stored import FrameEvents, StoredEvents
from .frozen import frozen
from .graph.haptic_graph import ObjectTable, large_patches
from .graph.impedances import ask_for_bodies
from .graph.object_frames import ObjectFrames, local_bounds
from .message import Message
from .scene.choices import Mode, Strategy
from .scene.functions import ModulationFunction
from .scene.impact_rule import ImpactRule
from .scene.rule_table import RuleTable
from .scene.rules import ImpactTemplates
from .scene.values import HapticObject, Source
from .unchanged import Unchanged


@frozen
class Collisions:
    """Collisions of one frame.

    Attributes:
        contacts: between objects, by their numbers in the table.
        frames: frames of reference of the objects, None if propagation does not need them.
        impacts: that began in this frame.
        sources: temporary sources of triggers, of sliding and rolling, and of active impacts.
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
    """Detects the contacts and events of consecutive frames.

    ``lazy``: contacts are detected only in heaps of bodies that hold a listener and a sound, and
    with ``paths`` only where a path between these may lead; gains and impacts are unaffected.

    Impacts need two consecutive frames. The events of frames are ``stored``, and restored in a
    frame with ``restore``, which was reached by a jump on the timeline or is traced a second time
    after an edit: modes, gains, materials and strategies are thus compared on the same impact,
    sliding and rolling. All stored events are dropped when bodies, shapes, masses, motions, or
    rules of contacts and impacts change, when a struck body has moved, and by `forget_events`,
    which is called after edits of animation and physics.
    """

    def __init__(self, settings: ContactSettings, lazy: bool, paths: bool = False) -> None:
        self.settings = settings
        self.lazy, self.paths = lazy, paths
        self.stored = StoredEvents()
        self._events = Events()
        self._tracker: ContactTracker | None = None
        self._interrupted: ContactTracker | None = None  # see `take_over`
        self._numbering = Unchanged(_Numbering)
        self._transmissions = Unchanged(_transmissions)
        self._numbered = Unchanged(_numbered)
        self._tracked = Unchanged(_tracked)
        self._without_materials = Unchanged(_without_materials)
        self._last: Frame | None = None
        # Impacts, and bodies that came, in frames that were passed by:
        self._passed: tuple[Impact, ...] = ()
        self._came: frozenset[str] = frozenset()

    def restore_events(self, number: int, bodies: tuple[Body, ...], kept: FrameEvents) -> None:
        """Replace all stored events by those of one frame of ``bodies``."""
        self.stored.clear()
        self.stored.store(number, kept, self._causes(bodies))

    def _causes(self, bodies: tuple[Body, ...]) -> tuple[tuple[Body, ...], ContactSettings]:
        """What events depend on beside motion."""
        if not self.settings.impact_table.rows:  # then materials make no impact
            bodies = self._without_materials(bodies)
        return bodies, self._tracked(self.settings)

    def forget_events(self) -> None:
        """Drop all stored events."""
        self.stored.clear()
        self._last = None

    def take_over(self, interrupted: CollisionDetector) -> None:
        """Take over the settings, the stored events and what is known of shapes of an interrupted
        detector, but not its contacts."""
        self.settings, self.lazy = interrupted.settings, interrupted.lazy
        self.stored = interrupted.stored
        self._interrupted = interrupted._tracker or interrupted._interrupted

    def is_retrace(self, frame: Frame) -> bool:
        """Whether ``frame`` is the one that was traced last, with the same poses and shapes: an
        edit has changed sources, listeners, materials or settings at most."""
        last = self._last
        return (
            last is not None
            and self._tracker is not None
            and self._tracker.settings == self._tracked(self.settings)
            and frame.transforms is not None
            and (last.number, last.time, last.bodies) == (frame.number, frame.time, frame.bodies)
            and last.transforms is not None
            and np.array_equal(last.transforms, frame.transforms)
        )

    def history(self) -> bytes:
        """The state of contacts and events that later frames depend on."""
        arrays = () if self._tracker is None else self._tracker.history()
        return b"".join(
            [
                self._events.history().encode(),
                *(np.ascontiguousarray(array).tobytes() for array in arrays),
            ]
        )

    def reset(self) -> None:
        """Drop contact history, velocities and active events."""
        self._events.clear()
        self._passed, self._came = (), frozenset()
        if self._tracker is not None:
            self._tracker.reset()

    @property
    def delays(self) -> Mapping[str, float]:
        """Largest delay of each source at the listeners [s], by name."""
        return self._events.shots.delays

    def set_delays(self, delays: Mapping[str, float]) -> None:
        """Extend temporary sources by their largest delays at the listeners [s], given by name."""
        self._events.set_delays(delays)

    def pass_by(self, frame: Frame, table: ObjectTable) -> None:
        """Follow the bodies to a frame that is not told: what strikes on the way there is told in
        the next frame."""
        impacts = frame.struck or ()
        if frame.contacts is None and frame.bodies:
            tracker = self._follow(frame.bodies, frame.anew)
            numbering = self._numbering(frame.objects, frame.bodies, table)
            rules = self._transmissions(self.settings.transmission_table, table)
            impacts = self._found(frame, tracker, numbering, rules, self._events).impacts
        self._passed += impacts
        self._came |= frame.anew

    def detect(
        self, frame: Frame, table: ObjectTable, previous: float | None, retrace: bool = False
    ) -> Collisions:
        """Return the collisions of a frame: its contacts, then each kind of event.

        Args:
            frame: the frame.
            table: numbers its objects.
            previous: time of the frame before it [s], None without one.
            retrace: the frame `is_retrace`. It is detected as after a jump, by copies of what later
                frames continue from.
        """
        begun = perf_counter()
        since = None if retrace else previous
        bodies = frame.contacts is None and len(frame.bodies) > 0
        tracker = self._follow(frame.bodies, frame.anew) if bodies else None
        events = self._events
        if retrace and tracker is not None:
            events, tracker = events.copy(), copy.copy(tracker)
            tracker.reset()
        kept = None  # the stored events of this frame, where they are restored
        if bodies and (retrace or (frame.restore and previous is None)):
            kept = self._restorable(frame)
            events.restore(kept, frame, self.settings)
        if tracker is None:
            contacts, frames = _given(frame, table)
            found = FrameContacts(contacts, frame.struck or (), ContactStatistics(), ())
        else:
            numbering = self._numbering(frame.objects, frame.bodies, table)
            rules = self._transmissions(self.settings.transmission_table, table)
            found = self._found(frame, tracker, numbering, rules, events)
            contacts = self._numbered(found.contacts, numbering, rules, frame.authored)
            frames = numbering.frames(frame, contacts)
        found = replace(found, impacts=self._passed + found.impacts)
        came = replace(frame, anew=frame.anew | self._came) if self._came else frame
        self._passed, self._came = (), frozenset()
        sources = events.follow(came, since, found, self.settings)
        if tracker is not None:
            self._last = frame
            if since is not None:
                self.stored.store(
                    frame.number, events.snapshot(since, frame), self._causes(frame.bodies)
                )
        broad = found.statistics.broad_seconds
        return Collisions(
            contacts=contacts,
            frames=frames,
            impacts=events.impacts.began,
            sources=sources,
            statistics=found.statistics.counts if bodies else {},
            milliseconds={"broad": 1000 * broad, "narrow": 1000 * (perf_counter() - begun - broad)},
            warnings=found.warnings,
            start=None if kept is None else kept.start,
            shots=events.shots.active,
        )

    def _restorable(self, frame: Frame) -> FrameEvents | None:
        """The stored events of a frame; all are dropped if a struck body has moved."""
        kept = self.stored.of(frame.number)
        if kept is None or frame.transforms is None or not kept.bodies_unmoved(frame.transforms):
            if kept is not None:
                self.forget_events()
            return None
        return kept

    def _follow(self, bodies: tuple[Body, ...], anew: frozenset[str]) -> ContactTracker:
        """Return a tracker of ``bodies``: the current one if the settings are the same."""
        tracker = self._tracker
        settings = self._tracked(self.settings)
        self.stored.heed(self._causes(bodies))
        if tracker is None or tracker.settings != settings:
            before, self._interrupted = tracker or self._interrupted, None
            tracker = self._tracker = ContactTracker(bodies, settings, before)
            self._events.impacts.clear()
            self._events.rubbing.clear()
        elif anew or tracker.bodies != bodies:
            tracker.replace_bodies(bodies, anew)
        tracker.bodies = bodies  # which are the sooner known to be the same in the next frame
        return tracker

    def _found(
        self,
        frame: Frame,
        tracker: ContactTracker,
        numbering: _Numbering,
        rules: TransmissionRules,
        events: Events,
    ) -> FrameContacts:
        """The contacts between bodies, and the impacts since the frame before."""
        found = tracker.update(
            frame.time,
            frame.placed,
            self._endpoints(frame, numbering.row, rules.uses_force, events),
            frame.continuous,
            frame.struck is None and self.settings.impacts,
            frame.exact,
            frame.motion,
        )
        return found if frame.struck is None else replace(found, impacts=frame.struck)

    def _endpoints(
        self, frame: Frame, row: Mapping[Any, int], every_contact: bool, events: Events
    ) -> Endpoints | None:
        """Return where signals begin and end, to which the detection of contacts is restricted:
        bodies, numbered by name in ``row``, with active sources, ``events`` among them, and with
        listeners, none in a mode without propagation through contacts. None if all contacts are
        needed: for a frame that is not lazy, and for ``every_contact``."""
        # Forces (each depends on all others), triggers and textures use contacts without a signal.
        if (
            not self.lazy
            or frame.authored is not None
            or every_contact
            or self.settings.textures.rows
        ):
            return None
        count = len(frame.bodies)
        heard, sounding = np.zeros((2, len(frame.objects)), dtype=np.bool_)
        if frame.settings.mode in (Mode.HT, Mode.SD):
            names = [
                name
                for source in frame.sources
                if source.amplitude > 0
                for name in (source.object, source.second_object)
            ]
            names += [name for item in events.impacts.active for name in item.bodies]
            heard[
                [row[listener.object] for listener in frame.listeners if listener.object in row]
            ] = True
            sounding[[row[name] for name in names if name in row]] = True
            struck = [k for one in (*self._passed, *(frame.struck or ())) for k in one.objects]
            sounding[[number for number in struck if number < count]] = True
        paths = self.paths and frame.settings.strategy is Strategy.BEST_PATH
        return Endpoints(heard[:count], sounding[:count], paths)


def _given(frame: Frame, table: ObjectTable) -> tuple[ContactSet, ObjectFrames | None]:
    """The contacts of a frame whose contacts are given, and the objects' frames of reference if
    something asks for them."""
    contacts = ContactSet.empty() if frame.contacts is None else frame.contacts
    asked = _asks_for_frames(contacts, table)
    return contacts, ObjectFrames.of_objects(frame.objects, frame.transforms) if asked else None


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

    ``row``: the number of an object in its frame, which is that of its body, by name. ``objects``
    (n,): the number of each body's object in the table.
    """

    def __init__(
        self, objects: tuple[HapticObject, ...], bodies: tuple[Body, ...], table: ObjectTable
    ) -> None:
        self.bodies, self._table = bodies, table
        self._count = len(table.names)
        self.row = {item.name: number for number, item in enumerate(objects)}
        self._placed = Unchanged(self._frames_of)
        index = table.index()
        self.objects: IntArray = np.array([index[body.name] for body in bodies], dtype=np.int64)

    def frames(self, frame: Frame, contacts: ContactSet) -> ObjectFrames | None:
        """The frames of reference of the objects that something asks for, None if nothing does:
        gains for all that touch, and the axes of listeners with an extent, as it depends on how
        they are turned where on them vibration arrives."""
        transforms = frame.transforms
        assert transforms is not None
        # What touches stands still while its contacts are the same, unless they are authored.
        moment = None if frame.authored is None else frame.time
        frames = self._placed(contacts, moment, transforms=transforms)
        turned = [item.object for item in frame.listeners if item.radius > 0]
        if not turned:
            return frames
        index = self._table.index()
        poses = transforms[[self.row[name] for name in turned]]
        frames = frames or ObjectFrames.unknown(self._count)
        return frames.turned(np.array([index[name] for name in turned]), poses)

    def _frames_of(
        self, contacts: ContactSet, _: float | None, transforms: FloatArray
    ) -> ObjectFrames | None:
        """The frames of reference of the objects that touch, None if nothing asks for them."""
        if not _asks_for_frames(contacts, self._table, self.sizes):
            return None
        touching = np.zeros(self._count, dtype=np.bool_)
        touching[contacts.pairs] = True
        rows = touching[self.objects].nonzero()[0]
        return ObjectFrames.unknown(self._count).placed(
            self.objects[rows], self.bounds[rows], transforms[rows]
        )

    @cached_property
    def sizes(self) -> FloatArray:
        """The sizes (n, 3) of the objects' bounding boxes [m], NaN without a body."""
        sizes = np.full((self._count, 3), math.nan)
        sizes[self.objects] = np.ptp(self.bounds, axis=1)
        return sizes

    @cached_property
    def bounds(self) -> FloatArray:
        """The bodies' local bounding boxes (n, 2, 3)."""
        return local_bounds([body.shape for body in self.bodies])


def _asks_for_frames(
    contacts: ContactSet, table: ObjectTable, sizes: FloatArray | None = None
) -> bool:
    """Whether gains depend on where the objects lie. ``sizes`` (n, 3): of their boxes [m], if they
    are known."""
    return (
        any(function.uses_force for function in contacts.transmissions)
        or ask_for_bodies(table.bodies, contacts)
        or len(large_patches(table, contacts, sizes)) > 0
    )
