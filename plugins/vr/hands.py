"""Two hands that follow the controllers, as bodies of frames that are traced beside the scene's own
ones: they are no objects of Blender, and nothing of them is saved or undone.

A frame of the session is traced on a thread of its own, and its samples go to the controllers.
"""

from __future__ import annotations

from collections.abc import Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from ...core.arrays import FloatArray
from ...core.contacts.settings import Body, ContactSettings
from ...core.contacts.shapes import Capsule, Compound, pose_matrix
from ...core.frozen import frozen
from ...core.render.frame_result import FrameResult
from ...core.render.levels import vibration_rms
from ...core.scene.impact_rule import ImpactLimits, ImpactRule
from ...core.scene.materials import MATERIALS
from ...core.scene.rule_table import Rule, RuleTable, Side
from ...core.scene.values import HapticObject, Listener, Pose
from ...core.tracer import Frame, Tracer

if TYPE_CHECKING:
    from ...addon.scene_reader.reading import Reading

PARTS = {"left": "hand.L", "right": "hand.R"}
NAMES = {hand: f"VR hand, {hand}\0" for hand in PARTS}
"""No object of Blender has such a name, recorded hands neither: they may be in the scene."""
_MASS = 0.5  # kg
_KNOCKS = ImpactLimits(least_energy=0.01, full_energy=2.0, refractory=0.1)  # 0.2 and 2.8 m/s
_MOST_FRAMES = 4  # of the timeline that may be dropped while it plays
_LONGEST_GLIDE = 0.1  # seconds
_PATIENCE = 0.005  # seconds for which a frame of the session waits for its trace


def _hand() -> Compound:
    """A palm and five fingertips in the space of OpenXR's grip: the palm lies along z, from the
    thumb (-z) to the little finger, and the fingers point to -y."""
    along_y = np.sqrt(0.5), np.sqrt(0.5), 0.0, 0.0
    tips = [(0.0, -0.035, -0.055), *((0.0, -0.085, z) for z in (-0.03, -0.01, 0.01, 0.03))]
    return Compound.of(
        (
            (Capsule(0.028, 0.04), Pose()),
            *((Capsule(0.008, 0.015), Pose(place, along_y)) for place in tips),
        )
    )


SHAPE = _hand()
_FLESH = MATERIALS["flesh"]
OBJECTS = tuple(
    HapticObject(name, _FLESH.kappa, _FLESH.rho, mass=_MASS, material=_FLESH.name)
    for name in NAMES.values()
)
BODIES = tuple(Body(item.name, SHAPE, _MASS, material=item.material) for item in OBJECTS)

Grips = Mapping[str, tuple[tuple[float, float, float], tuple[float, float, float, float]]]
"""Location [m, world] and rotation (w, x, y, z) of the grip of each controller that is tracked."""


@frozen
class Felt:
    """A traced frame of the session. hands: those that there are, k of two. transforms: theirs,
    (k, 4, 4)."""

    hands: tuple[str, ...]
    transforms: FloatArray
    result: FrameResult

    @property
    def block(self) -> FloatArray | None:
        """The samples of both hands (2, n), None if there are none."""
        if self.result.block is None:
            return None
        block = np.zeros((len(NAMES), self.result.block.shape[1]))
        block[[hand in self.hands for hand in NAMES]] = self.result.block
        return block

    @property
    def levels(self) -> FloatArray:
        """The amplitudes (k,) at which the hands vibrate."""
        block = self.result.block
        if block is None:
            return np.zeros(len(self.hands))
        return np.sqrt(2.0) * vibration_rms(block, self.result.sample_rate)


@lru_cache(maxsize=1)
def settings_of(settings: ContactSettings) -> ContactSettings:
    """The scene's settings, with limits of impacts for knocks: they have less energy than what the
    scene's limits are made for."""
    knocks = tuple(
        Rule((Side(object=name), Side()), ImpactRule(limits=_KNOCKS)) for name in NAMES.values()
    )
    table = RuleTable((*settings.impact_table.rows, *knocks))
    return replace(settings, impact_table=table)


def frame_of(
    reading: Reading,
    transforms: FloatArray,
    grips: Grips,
    time: float,
    number: int,
    continuous: bool = True,
) -> Frame:
    """The frame of a session: the scene as it was read last, and the hands, which alone feel.
    One-shots belong to the timeline and are left out.

    Args:
        reading: of the scene.
        transforms: of its bodies now (n, 4, 4).
        grips: poses of the hands that are held.
        time: of the frame [s].
        number: of the frame.
        continuous: whether it follows the last one.
    """
    hands = [
        (hand, item, body, Pose(*grips[hand]))
        for hand, item, body in zip(NAMES, OBJECTS, BODIES, strict=True)
        if hand in grips
    ]
    matrices = np.array([pose_matrix(pose) for *_, pose in hands]).reshape(-1, 4, 4)
    return Frame(
        number=number,
        time=time,
        objects=(*reading.objects, *(item for _, item, _, _ in hands)),
        sources=tuple(source for source in reading.sources if source.triggers is None),
        listeners=tuple(
            Listener(item.name, item.name, pose.position, PARTS[hand], radius=0.1)
            for hand, item, _, pose in hands
        ),
        settings=reading.settings,
        bodies=(*reading.bodies, *(body for _, _, body, _ in hands)),
        transforms=np.concatenate([transforms, matrices]),
        continuous=continuous,
    )


@dataclass(slots=True)
class Glide:
    """Interpolates the bodies of a scene between two frames of the timeline, because a session has
    more frames than the timeline. They are one frame of the timeline late, so that both ends are
    known and their speeds are right.

    Attributes:
        before: transforms at the earlier of both (n, 4, 4).
        after: transforms at the later one (n, 4, 4).
        frame: number of the later one, None while the timeline does not play.
        arrived: time of the session at which it was read [s].
        seconds: how long the way from one to the other takes.
    """

    before: FloatArray = field(default_factory=lambda: np.zeros((0, 4, 4)))
    after: FloatArray = field(default_factory=lambda: np.zeros((0, 4, 4)))
    frame: int | None = None
    arrived: float = -np.inf
    seconds: float = 0.0

    def at(self, transforms: FloatArray, frame: int | None, time: float) -> tuple[FloatArray, bool]:
        """The transforms at ``time`` [s], and whether they continue the last ones. transforms: as
        read last. frame: of the timeline, None while it does not play."""
        continues = True
        if transforms is not self.after:
            continues = (
                frame is not None
                and self.frame is not None
                and 0 < frame - self.frame <= _MOST_FRAMES
                and transforms.shape == self.after.shape
            )
            self.before = self._now(time) if continues else transforms
            self.seconds = min(time - self.arrived, _LONGEST_GLIDE)
            self.after, self.arrived = transforms, time
        self.frame = frame
        return self._now(time), continues

    def _now(self, time: float) -> FloatArray:
        share = (time - self.arrived) / self.seconds if self.seconds > 0 else 1.0
        if share >= 1 or self.before is self.after:
            return self.after
        now = self.before + share * (self.after - self.before)
        left, _, right = np.linalg.svd(now[:, :3, :3])
        now[:, :3, :3] = left @ right
        return np.asarray(now)


@dataclass(slots=True)
class Hands:
    """The tracing of a session's frames.

    Attributes:
        tracer: of the scene with the hands.
        thread: on which it traces.
        running: the trace that runs.
        felt: the result of the last trace.
        failure: why the scene can't be traced, until it can.
        objects: haptic objects of the reading traced last.
        glide: places the bodies between two frames of the timeline.
        number: of the last frame of the session.
    """

    tracer: Tracer = field(default_factory=lambda: Tracer(lazy=True))
    thread: ThreadPoolExecutor = field(
        default_factory=lambda: ThreadPoolExecutor(1, "haptics VR hands")
    )
    running: Future[Felt] | None = None
    felt: Felt | None = None
    failure: Exception | None = None
    objects: tuple[HapticObject, ...] = ()
    glide: Glide = field(default_factory=Glide)
    number: int = 0

    def step(self, reading: Reading, frame: int | None, grips: Grips, time: float) -> list[Felt]:
        """Trace the frame of the session at ``time`` [s]. Returns what was traced since the last
        call, with this frame if that is quick.

        Args:
            reading: of the scene.
            frame: of the timeline, None while it does not play.
            grips: poses of the hands.
            time: of the session [s].
        """
        felt = self._collect(0.0)
        if self.running is None:
            transforms, continues = self.glide.at(reading.transforms, frame, time)
            continues = continues and reading.objects is self.objects and self.number > 0
            self.objects = reading.objects
            self.number = self.number + 1
            given = frame_of(reading, transforms, grips, time, self.number, continues)
            self.tracer.collisions.settings = settings_of(reading.contact_settings)
            self.running = self.thread.submit(self._trace, given, tuple(grips))
            felt += self._collect(_PATIENCE)
        return felt

    def _trace(self, frame: Frame, hands: tuple[str, ...]) -> Felt:
        assert frame.transforms is not None
        transforms = frame.transforms[len(frame.transforms) - len(hands) :]
        return Felt(hands, transforms, self.tracer.step(frame))

    def _collect(self, patience: float) -> list[Felt]:
        """The frame that was being traced, if it is complete within ``patience`` [s]."""
        if self.running is None:
            return []
        try:
            self.felt = self.running.result(patience)
            self.failure = None
        except TimeoutError:
            return []
        except Exception as error:  # the panel says it; the session goes on
            self.felt, self.failure = None, error
            self.tracer = Tracer(lazy=True)
            self.number = 0
        self.running = None
        return [] if self.felt is None else [self.felt]

    def end(self) -> None:
        """Wait for the trace, and end the thread."""
        self.thread.shutdown(cancel_futures=True)
