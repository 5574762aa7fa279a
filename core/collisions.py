"""Collision detection of one frame: contacts between objects as the graph numbers them, impacts, and the sources that impacts make."""

from __future__ import annotations

import copy
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from time import perf_counter

import numpy as np

from .arrays import FloatArray, IntArray
from .contacts.authored import AuthoredContacts
from .contacts.contact_set import ContactSet
from .contacts.gain_bound import GainBound
from .contacts.impact_sources import MOST_FRAMES, FrameImpacts, ImpactSources, Templates
from .contacts.one_shots import OneShots, Shot
from .contacts.rubbing import Rubbing
from .contacts.tracker import Body, ContactSettings, ContactTracker, FrameContacts, Impact
from .contacts.transmissions import TransmissionRules
from .graph.gain_bounds import object_bounds, signal_gain_bound
from .graph.haptic_graph import ObjectTable
from .graph.object_frames import ObjectFrames, local_centres
from .message import Message
from .scene.choices import Strategy
from .scene.functions import ModulationFunction
from .scene.impact_rule import ImpactRule
from .scene.rule_table import RuleTable
from .scene.rules import ImpactTemplates
from .scene.values import HapticObject, Listener, Settings, Source, TriggerKind, Vector
from .signals import Signal

EXACT_FRAMES = 32
"""Frames whose number is a multiple of this are `Frame.exact`: those after them can be traced without those before, to the same bits."""


@dataclass(frozen=True, slots=True)
class Frame:
    """The state of a scene at one frame.

    ``time`` [s]; the tracer renders the samples from the previous frame's time to this one's, so that an impact between the two sounds
    when it happened. ``continuous``: this frame follows the one traced last; otherwise contact history, velocities and sounding signals
    are dropped. Either bodies move, then ``transforms`` (n, 4, 4) are the rigid world transforms of ``bodies``, which are ``objects`` in
    the same order; or ``contacts`` are given, which number the objects by their sorted names. ``authored`` contacts replace detected
    ones. ``recall``: a frame that does not follow has the impacts that it had when it was last stepped to, see `CollisionDetector`.
    ``exact``: contacts and gains are computed anew also where things have moved by less than counts otherwise. ``duration`` [s]: of a frame
    that follows none, in which triggers at given times count.
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
    recall: bool = False
    exact: bool = False
    duration: float = 0.0


@dataclass(frozen=True, slots=True)
class Collisions:
    """Collisions of one frame. ``sources``: those of ``shots`` of sources with triggers and of impacts that still sound, and of what slides
    or rolls. ``frames``: where the objects lie, None where propagation does not ask. ``start`` [s]: of the frame, where its impacts are
    recalled."""

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

    ``lazy``: contacts are detected only where a signal of at least the threshold can arrive; gains and impacts are the same.
    ``impact_signal``: played by impacts without templates of their materials. ``transmission``: the function of all detected contacts,
    None for the identity.

    Impacts take two frames that follow each other. The impacts of each frame are remembered, at most `MOST_FRAMES` frames of them, for
    frames with ``recall``: come to by a jump, or detected again after an edit, they have the same impacts as before, and the same slides
    and rolls. So modes, gains, materials and strategies are compared on the same blow. What makes impacts drops all that is remembered:
    other bodies, shapes, masses or motions, other rules of contacts and impacts, a struck body that stands elsewhere, and
    `forget_impacts`, which whoever knows of edits of animation and physics calls.
    """

    def __init__(self, settings: ContactSettings, impact_signal: Signal, transmission: ModulationFunction | None, lazy: bool) -> None:
        self.settings = settings
        self.transmission = transmission
        self.lazy = lazy
        self._impact_signal = impact_signal
        self._sources = ImpactSources()
        self._rubbing = Rubbing(EXACT_FRAMES)
        self._shots = OneShots()
        self._tracker: ContactTracker | None = None
        self._numbering = _Numbering((), ObjectTable.of((), 0.0))
        self._found: FrameContacts | None = None
        self._authored: AuthoredContacts | None = None
        self._contacts = ContactSet.empty()
        self._passed: tuple[ObjectTable, TransmissionRules] | None = None
        self._remembered: dict[int, FrameImpacts] = {}
        self._rules: tuple[tuple[Body, ...], ContactSettings] | None = None
        self._unnamed: tuple[tuple[Body, ...], tuple[Body, ...]] = (), ()  # bodies, and the same without materials
        self._known: tuple[ContactSettings | None, ContactSettings] = None, settings  # the settings, and of these what is `_tracked`
        self._last: Frame | None = None
        self._bound: tuple[tuple[object, ...], GainBound] | None = None  # what it was made of, and it

    @property
    def _tracked(self) -> ContactSettings:
        """What contacts and impacts are found by: the settings without what is made of impacts."""
        if self._known[0] is not self.settings:
            rows = tuple(replace(row, does=ImpactRule(limits=row.does.limits)) for row in self.settings.impact_table.rows)
            settings = replace(
                self.settings,
                impacts=True,
                templates=ImpactTemplates.PLAIN,
                impact_table=RuleTable(rows),
                transmission_table=RuleTable(),
                textures=RuleTable(),
            )
            self._known = self.settings, settings
        return self._known[1]

    @property
    def remembers(self) -> bool:
        """True where impacts of some frame are remembered, or what slides or rolls in it."""
        return bool(self._remembered)

    def impacts_of(self, number: int) -> FrameImpacts | None:
        """Return the impacts that are remembered of a frame."""
        return self._remembered.get(number)

    def restore_impacts(self, number: int, bodies: tuple[Body, ...], kept: FrameImpacts) -> None:
        """Remember the impacts of a frame of ``bodies`` from elsewhere, and nothing else."""
        self._rules = self._rules_of(bodies)
        self._remembered = {number: kept}

    def _rules_of(self, bodies: tuple[Body, ...]) -> tuple[tuple[Body, ...], ContactSettings]:
        if not self.settings.impact_table.rows:  # then materials make no impact
            if self._unnamed[0] is not bodies:
                self._unnamed = bodies, tuple(replace(body, material="") for body in bodies)
            bodies = self._unnamed[1]
        return bodies, self._tracked if not self._tracked.patch_points else replace(self._tracked, patch_points=False)

    def forget_impacts(self) -> None:
        """Something that makes impacts has changed."""
        self._remembered.clear()
        self._last = None

    def take_over(self, interrupted: CollisionDetector) -> None:
        """Take over the settings and the remembered impacts of a detector that was interrupted, but none of its contacts."""
        self.settings, self.lazy = interrupted.settings, interrupted.lazy
        self._remembered, self._rules = interrupted._remembered, interrupted._rules

    def stands(self, frame: Frame) -> bool:
        """Whether ``frame`` is the one that was detected last, and nothing in it has moved or changed its shape."""
        if self._last is None or self._tracker is None or frame.transforms is None or self._tracker.settings != self._tracked:
            return False
        last = self._last
        alike = (last.number, last.time) == (frame.number, frame.time) and (last.bodies is frame.bodies or last.bodies == frame.bodies)
        return alike and last.transforms is not None and np.array_equal(last.transforms, frame.transforms)

    def history(self) -> bytes:
        """All that later frames take over of contacts and impacts."""
        arrays = () if self._tracker is None else self._tracker.history()
        sources = repr((self._sources.names, self._shots.sounding)) + self._rubbing.history()
        return b"".join([sources.encode(), *(np.ascontiguousarray(array).tobytes() for array in arrays)])

    def reset(self) -> None:
        """Drop contact history, velocities and sounding impacts."""
        self._sources.clear()
        self._rubbing.clear()
        self._shots.clear()
        if self._tracker is not None:
            self._tracker.reset()

    @property
    def late(self) -> Mapping[str, float]:
        """By how many seconds the listeners feel a source later, by its name."""
        return self._shots.late

    def hold(self, late: Mapping[str, float]) -> None:
        """Keep temporary sources for as many seconds longer as the listeners feel them later, by their names."""
        self._sources.late = self._shots.late = late

    def detect(self, frame: Frame, table: ObjectTable, previous: float | None, again: bool = False) -> Collisions:
        """Return the collisions of ``frame``; ``table`` numbers its objects, ``previous`` is the time of the frame before it, if any.

        again: it `stands`; contacts are looked for anew, and what follows it goes on as if it had been detected once.
        """
        if frame.contacts is not None or not frame.bodies or frame.transforms is None:
            self._sources.clear()
            contacts = ContactSet.empty() if frame.contacts is None else frame.contacts
            frames = ObjectFrames.of_objects(table.objects) if _asks_for_frames(frame.settings, contacts) else None
            return Collisions(contacts, frames, sources=self._one_shots(frame, previous, None, ()), shots=self._shots.sounding)
        begun = perf_counter()
        tracker = self._follow(frame.bodies, table)
        kept = None
        if again:
            tracker = copy.copy(tracker)
            tracker.reset()
        elif previous is not None:
            self._sources.end_before(previous)
        if again or (frame.recall and previous is None):
            self._sources.clear()
            kept = self._recalled(frame.number, frame.transforms)
        recalled = () if kept is None or not self.settings.impacts else self._sources.recall(kept, self._templates(frame))
        rules = self._transmissions(table)
        # The force of a contact depends on all the others.
        hits = any(trigger.on is TriggerKind.HIT for source in frame.sources for trigger in source.triggers or ())
        lazy = self.lazy and frame.authored is None and not rules.uses_force and not hits and not self.settings.textures.rows
        reach = self._reach(frame, frame.transforms) if lazy else None
        found = tracker.update(frame.time, frame.transforms, reach, frame.continuous, self.settings.impacts or hits, frame.exact)
        contacts = self._numbered(found, frame.authored, rules)
        broad, total = found.statistics.broad_seconds, perf_counter() - begun
        impacts = found.impacts if self.settings.impacts else ()
        if impacts:
            self._sources.add(impacts, [body.name for body in frame.bodies], frame.transforms, self._templates(frame))
        shots = self._one_shots(frame, previous, kept, found.impacts, again)
        rubbing = self._rub(frame, frame.transforms, found, previous, kept, again)
        if previous is not None and not again:
            self._remember(frame.number, self._sources.kept(previous, frame.transforms, self._shots.sounding, self._rubbing.kept))
        self._last = frame
        return Collisions(
            contacts=contacts,
            frames=self._numbering.frames(frame.transforms) if _asks_for_frames(frame.settings, contacts) else None,
            impacts=impacts or recalled,
            sources=shots + rubbing + self._sources.sources(frame.transforms),
            statistics={
                "candidate_pairs": found.statistics.candidates,
                "contact_queries": found.statistics.queries,
                "queries_avoided": found.statistics.avoided,
            },
            milliseconds={"broad": 1000 * broad, "narrow": 1000 * (total - broad)},
            warnings=found.warnings,
            start=None if kept is None else kept.start,
            shots=self._shots.sounding,
        )

    def _rub(
        self, frame: Frame, transforms: FloatArray, found: FrameContacts, previous: float | None, kept: FrameImpacts | None, again: bool
    ) -> tuple[Source, ...]:
        """Return the sources of what slides or rolls since ``previous`` [s], or of what did so in a frame that is ``kept``."""
        if not self.settings.textures.rows:
            self._rubbing.clear()
            return ()
        if not again:
            span, middles = None if previous is None else (previous, frame.time), self._numbering.middles()
            self._rubbing.follow(frame.number, span, frame.bodies, found.contacts, transforms, middles, self.settings)
        if kept is not None and kept.rubbed is not None:
            self._rubbing.recall(kept.rubbed)
        return self._rubbing.sources(frame.bodies, self.settings.textures)

    def _one_shots(
        self, frame: Frame, previous: float | None, kept: FrameImpacts | None, impacts: Sequence[Impact], again: bool = False
    ) -> tuple[Source, ...]:
        """Find the triggers since ``previous`` [s], or recall those ``kept``. Returns the temporary sources that they make."""
        sources = [source for source in frame.sources if source.triggers]
        if not sources:
            self._shots.clear()
            return ()
        if again or kept is not None:
            self._shots.recall(() if kept is None else kept.shots, sources)
        if not again:
            names = [body.name for body in frame.bodies]
            hits = [((names[a], names[b]), impact.time, impact.amplitude) for impact in impacts for a, b in (impact.objects,)]
            self._shots.follow(sources, previous, frame.time, _places(frame), hits)
        start = next(time for time in (None if kept is None else kept.start, previous, frame.time - frame.duration) if time is not None)
        return self._shots.sources(sources, start, frame.time, frame.objects, self.settings)

    def _recalled(self, number: int, transforms: FloatArray) -> FrameImpacts | None:
        """Return what is remembered of a frame; nothing at all is any more where a struck body stands elsewhere."""
        kept = self._remembered.get(number)
        if kept is not None and not kept.stands(transforms):
            self.forget_impacts()
            kept = None
        return kept

    def _remember(self, number: int, kept: FrameImpacts | None) -> None:
        self._remembered.pop(number, None)
        if kept is not None:
            self._remembered[number] = kept
            if len(self._remembered) > MOST_FRAMES:
                del self._remembered[next(iter(self._remembered))]

    def _templates(self, frame: Frame) -> Templates:
        """Return what the impacts of a frame play."""
        return Templates(self.settings, {item.name: item for item in frame.objects}, self._impact_signal)

    def _follow(self, bodies: tuple[Body, ...], table: ObjectTable) -> ContactTracker:
        """Return a tracker of ``bodies``: the present one while they have the same names and the settings are the same."""
        tracker = self._tracker
        rules = self._rules_of(bodies)
        if self._rules != rules:
            self.forget_impacts()
            self._rules = rules
        if tracker is None or tracker.settings != self._tracked or not _same_names(tracker.bodies, bodies):
            tracker = self._tracker = ContactTracker(bodies, self._tracked)
            self._sources.clear()
            self._rubbing.clear()
        elif tracker.bodies is not bodies:
            if tracker.bodies != bodies:
                tracker.replace_bodies(bodies)
            tracker.bodies = bodies  # known by identity in the next frame
        if self._numbering.bodies is not bodies or self._numbering.table is not table:
            self._numbering = _Numbering(bodies, table)
            self._found = None
        return tracker

    def _transmissions(self, table: ObjectTable) -> TransmissionRules:
        """Return the functions of contacts by the rules of the scene, the same object while these and the objects are the same."""
        rows = self.settings.transmission_table
        if self._passed is None or self._passed[0] is not table or self._passed[1].table is not rows:
            self._passed = table, TransmissionRules(rows, [(item.name, item.material) for item in table.objects], self.transmission)
            self._found = None
        return self._passed[1]

    def _numbered(self, found: FrameContacts, authored: AuthoredContacts | None, rules: TransmissionRules) -> ContactSet:
        """Return the contacts between objects instead of bodies, the authored ones in place of those detected."""
        if self._found is None or found.contacts is not self._found.contacts or authored is not self._authored:
            self._contacts = rules.over(replace(found.contacts, pairs=self._numbering.objects[found.contacts.pairs]))
            if authored is not None:
                self._contacts = authored.over(self._contacts)
        self._found, self._authored = found, authored
        return self._contacts

    def _reach(self, frame: Frame, transforms: FloatArray) -> GainBound:
        """Return where signals of the sources can arrive, the same object while that is the same."""
        row = self._numbering.row
        starts: list[tuple[int, Vector]] = []
        for source in frame.sources:
            for name, position in ((source.object, source.position), (source.second_object, source.second_position)):
                if source.amplitude > 0 and name in row and position is not None:
                    starts.append((row[name], position))
        bodies, positions = self._sources.places(transforms)
        functions = self._transmissions(self._numbering.table).functions
        key = starts, bodies.tobytes(), positions.tobytes(), self._numbering, functions, frame.settings, self.settings.impacts
        if self._bound is None or self._bound[0] != key:
            bodies = np.concatenate([np.array([body for body, _ in starts], dtype=np.int64), bodies])
            positions = np.concatenate([np.array([position for _, position in starts], dtype=np.float64).reshape(-1, 3), positions])
            bounds = self._numbering.gain_bounds(frame.settings)
            self._bound = key, signal_gain_bound(bounds, bodies, positions, frame.settings, functions, self.settings.impacts)
        return self._bound[1]


class _Numbering:
    """How bodies and the objects of a table are numbered.

    ``row``: the number of a body by name. ``objects`` (n,): the number of each body's object.
    """

    def __init__(self, bodies: tuple[Body, ...], table: ObjectTable) -> None:
        self.bodies = bodies
        self.table = table
        self.row = {body.name: number for number, body in enumerate(bodies)}
        index = table.index()
        self.objects: IntArray = np.array([index[body.name] for body in bodies], dtype=np.int64)
        self._bounds: tuple[Settings, tuple[FloatArray, FloatArray]] | None = None
        self._centres: FloatArray | None = None

    def frames(self, transforms: FloatArray) -> ObjectFrames:
        """Return where the objects lie when the bodies have these rigid ``transforms`` (n, 4, 4)."""
        return ObjectFrames.unknown(len(self.table.names)).placed(self.objects, self.middles(), transforms)

    def middles(self) -> FloatArray:
        """Return the middles (n, 3) of the bodies' bounds in their own space."""
        if self._centres is None:
            self._centres = local_centres([body.shape for body in self.bodies])
        return self._centres

    def gain_bounds(self, settings: Settings) -> tuple[FloatArray, FloatArray]:
        """Return factor and decay (n,) of each body such that its gain over d metres is at most ``factor * exp(-decay * d)``."""
        if self._bounds is None or self._bounds[0] != settings:
            factor, decay = object_bounds(self.table, settings)
            self._bounds = settings, (factor[self.objects], decay[self.objects])
        return self._bounds[1]


def _places(frame: Frame) -> dict[str, FloatArray]:
    """The positions (3,) of the objects' origins, by name."""
    if frame.transforms is not None:
        return dict(zip((body.name for body in frame.bodies), frame.transforms[:, :3, 3], strict=True))
    return {item.name: np.array(item.pose.position) for item in frame.objects if item.pose is not None}


def _asks_for_frames(settings: Settings, contacts: ContactSet) -> bool:
    return settings.strategy is Strategy.ENERGY_BALANCE or any(function.uses_force for function in contacts.transmissions)


def _same_names(first: Sequence[Body], second: Sequence[Body]) -> bool:
    return first is second or [body.name for body in first] == [body.name for body in second]
