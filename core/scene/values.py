"""The haptic scene as immutable values.

Terms and defaults are those of the Haptic Tracing paper. Lengths in metres, masses in kilograms,
times in seconds, amplitudes in [0, 1]. Constructors validate their arguments, so every scene object
is valid.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import KW_ONLY, MISSING, field
from typing import TYPE_CHECKING, Any, TypeVar

from .. import signals
from ..declaration import (
    MOST,
    Declared,
    check,
    choice,
    curve,
    extras,
    name_of,
    number,
    numbers,
    part,
    share,
    switch,
    text,
)
from ..forms import Form
from ..frozen import frozen
from ..perception import FullScale
from .body import BODY_PARTS
from .choices import Mode as Mode
from .choices import SourceKind as SourceKind
from .choices import Strategy as Strategy
from .functions import (
    MIXING_VARIABLES,
    HapticTracing,
    Identity,
    ModulationFunction,
    compile_expression,
    require_gains,
)
from .impact_rule import require_template
from .references import require_known, require_unique
from .rules import ContactSettings, Motion

if TYPE_CHECKING:
    from ..signals import Signal

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]


def _finite_vector(key: str, value: Iterable[float], length: int = 3) -> tuple[float, ...]:
    vector = tuple(map(float, value))
    # The sum is finite only where all terms are, and large terms that overflow it are rare.
    if len(vector) != length or not (math.isfinite(sum(vector)) or all(map(math.isfinite, vector))):
        raise ValueError(f"{key}: expected {length} finite numbers, got {vector!r}")
    return vector


def _name(key: str, value: str) -> None:
    if not isinstance(value, str) or not value:
        raise ValueError(f"{key}: expected a name, got {value!r}")


_Item = TypeVar("_Item")


def _with(item: _Item, **checked: Any) -> _Item:
    """A copy with other values of some fields. Unlike `dataclasses.replace` it repeats no
    validation, because positions change in every frame; so such an item has no slots."""
    copy = object.__new__(type(item))
    vars(copy).update(vars(item), **checked)
    return copy


MODES = {
    Mode.HT: ("Haptic Tracing", "Through touching objects, as their properties say"),
    Mode.SD: (
        "Single Nearest",
        "Only the listener nearest to each source, fading with distance alone",
    ),
    Mode.MD: (
        "All by Distance",
        "Every source directly to every listener, fading with distance alone",
    ),
    Mode.MN: ("All Alike", "Every source directly to every listener, without fading"),
}
STRATEGIES = {
    Strategy.BEST_PATH: ("Best Path", "The path that passes on most"),
    Strategy.AS_IN_THE_PAPER: (
        "As in the Paper",
        "The sum over all paths for persistent sources, the best path for impacts",
    ),
}


@frozen
class Settings(Declared):
    """Settings of propagation. The fields' declarations say what they are."""

    mode: Mode = choice(Mode.HT, "Mode", "The rendering", MODES)
    strategy: Strategy = choice(
        Strategy.BEST_PATH,
        "Strategy",
        "How the gain from a source to a listener is computed",
        STRATEGIES,
    )
    max_connections: int | None = number(
        32,
        "",
        "Longest path of a sum as in the paper, in connections through and between objects; null "
        "sets no limit",
        0,
        1_000_000,
        whole=True,
        optional=True,
    )
    threshold: float = share(
        0.001,
        "",
        "A path of a sum as in the paper ends where its gain falls below this part of the source; "
        "0 sets no limit",
    )
    epsilon: float = number(
        0.1,
        "",
        "Least attenuation per metre of the function haptic_tracing, also of materials that would "
        "transmit without loss. The paper's ε",
        0.0,
        unit="1/m",
    )


@frozen
class Pose:
    """Position in metres and rotation as a quaternion (w, x, y, z), normalised."""

    position: Vector = (0.0, 0.0, 0.0)
    rotation: Quaternion = (1.0, 0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        object.__setattr__(self, "position", _finite_vector("position", self.position))
        w, x, y, z = rotation = _finite_vector("rotation", self.rotation, 4)
        length = math.hypot(*rotation)
        if length < 1e-12:
            raise ValueError("rotation: a quaternion of length 0 is no rotation")
        # A normalised quaternion keeps all its bits, through any number of files.
        object.__setattr__(
            self,
            "rotation",
            rotation
            if abs(length - 1) < 1e-12
            else (w / length, x / length, y / length, z / length),
        )


KAPPA = share(
    MISSING,
    "Kappa (κ)",
    "A higher κ passes on less, but over a longer distance; 1 passes on nothing. The paper's "
    "transmissibility: as its "
    "function is published, only (1 - κ) ρ counts",
    digits=3,
    shown=0.1,
).metadata
RHO = share(
    MISSING,
    "Rho (ρ)",
    "A higher ρ passes on more but fades faster with distance; 0 passes on nothing. The paper's "
    "density coefficient",
    digits=3,
    shown=0.9,
).metadata
MOTIONS = {
    Motion.STATIC: ("", "Nothing"),
    Motion.KINEMATIC: ("", "Animation"),
    Motion.DYNAMIC: ("", "The simulation"),
}


ALL_LAYERS = 2**20 - 1
"""Layers of collision of an object that collides with all others."""


@frozen
class HapticObject:
    """An object that transmits haptic signals. ``shape``: see `core.contacts.shapes`.
    ``impact_material``: a key of `IMPACT_MATERIALS`."""

    name: str = field(metadata=name_of("Name, unique among objects").metadata)
    kappa: float = field(metadata=KAPPA)
    rho: float = field(metadata=RHO)
    propagation: ModulationFunction = part(
        HapticTracing(), "function", "Gain between two points of the object; default haptic_tracing"
    )
    shape: Any = part(
        None,
        "body_shape",
        "Collision shape from which contacts are found; none are found without it",
    )
    pose: Pose | None = part(
        None, "pose", "Position and rotation in the world; default: at the origin, not rotated"
    )
    mass: float | None = number(
        None, "", "Mass, for the energy of impacts", 0.0, 1e15, unit="kg", optional=True
    )
    medium: bool = switch(
        False,
        "Medium",
        "A volume such as air or water: it touches everything that it overlaps",
        context="Haptics",
    )
    extras: Form = extras()
    motion: Motion = choice(Motion.DYNAMIC, "", "What moves the object", MOTIONS)
    layers: int = number(
        ALL_LAYERS,
        "",
        "Layers of collision, as the sum of 1, 2, 4 and so on: objects without a common one pass "
        "through each other without impacts, sliding or rolling; default all",
        0,
        ALL_LAYERS,
        whole=True,
    )
    impact_material: str = part(
        "", "impact_material", "Material of the signal of the object's impacts; empty: unknown"
    )
    material: str = text(
        "",
        "",
        "Name of the material that the object is made of: one of the library, such as steel, or "
        "another for tables of rules",
    )

    def __post_init__(self) -> None:
        check(self)
        require_gains(self.propagation)
        if self.impact_material and self.impact_material not in signals.IMPACT_MATERIALS:
            raise ValueError(
                f"impact_material: {self.impact_material!r} is not one of "
                f"{', '.join(signals.IMPACT_MATERIALS)}"
            )


_IDENTITY = Identity()  # one for all contacts: recordings have hundreds of thousands


@frozen
class Contact:
    """Two touching objects: one contact node on each, ``positions[k]`` on ``objects[k]`` (world,
    metres).

    Contacts of one pair with a ``share`` below 1 are points of one patch: the graph has one contact
    at their share-weighted centre. ``weight`` multiplies its gain; it is less than 1 if the
    surfaces are further apart than those of bodies at rest. ``normal`` is a unit vector from the
    first object to the second.
    """

    objects: tuple[str, str] = field(
        metadata=part(MISSING, "pair", "Names of the two objects that touch").metadata
    )
    positions: tuple[Vector, Vector] = field(
        metadata=part(
            MISSING, "positions", "Position of the contact on the first and on the second object"
        ).metadata
    )
    transmission: ModulationFunction = part(
        _IDENTITY, "function", "Gain between the two positions, by their distance; default identity"
    )
    area: float = number(0.0, "", "Area of the patch", 0.0, 1e15, unit="m^2")
    normal: Vector = numbers(
        (0.0, 0.0, 1.0), "", "Direction from the first object to the second", 3
    )
    depth: float = number(0.0, "", "Penetration", -MOST, unit="m")
    share: float = number(
        1.0, "", "Fraction of its patch; the shares of a pair's contacts add up to 1", 0.0, 1.0
    )
    weight: float = number(
        1.0,
        "",
        "Factor of the contact's gain; less than 1 if the surfaces are near but do not touch",
        0.0,
        1.0,
    )
    extras: Form = extras()

    def __post_init__(self) -> None:
        first, second = self.objects
        _name("objects", first)
        _name("objects", second)
        if first == second:
            raise ValueError(f"objects: {first!r} can't touch itself")
        object.__setattr__(
            self, "positions", tuple(_finite_vector("positions", p) for p in self.positions)
        )
        check(self)
        require_gains(self.transmission, on_contact=True)


@frozen
class Trigger:
    """What makes a source play its signal once: ``times`` [s], each with its strength in [0, 1], 1
    without ``strengths``; or a ``value`` when it rises above 0, of which files store the times."""

    times: tuple[float, ...] = ()
    strengths: tuple[float, ...] = ()
    value: float | None = None

    def __post_init__(self) -> None:
        if not all(map(math.isfinite, self.times)):
            raise ValueError("times: must be finite")
        if self.strengths and len(self.strengths) != len(self.times):
            raise ValueError("strengths: expected as many as there are times")
        if not all(0 <= strength <= 1 for strength in self.strengths):
            raise ValueError(f"strengths: must lie in [0, 1], got {self.strengths!r}")


SOURCE_KINDS = {
    SourceKind.PERSISTENT: ("", "It plays on"),
    SourceKind.TEMPORARY: ("", "It ends with its signal, as those of impacts do"),
}


@frozen(slots=False)
class Source:
    """Emits a signal. A source of an impact, or of sliding or rolling, also excites
    ``second_object``, the other side of its contact. A source with ``triggers`` plays its signal
    only once per trigger; None: it plays without triggers."""

    name: str = field(metadata=name_of("Name, unique among sources").metadata)
    object: str = field(metadata=name_of("Name of the source's object").metadata)
    position: Vector = numbers(
        (0.0, 0.0, 0.0), "", "Position of the source", 3, unit="m", required=True
    )
    amplitude: float = share(1.0, "Amplitude", "Strength of the emitted signal; can be animated")
    kind: SourceKind = choice(SourceKind.PERSISTENT, "", "How long it lasts", SOURCE_KINDS)
    signal: Signal | None = part(
        None,
        "signal",
        "Its signal; default a hum for persistent sources, a knock for temporary ones",
    )
    second_object: str | None = name_of(
        "The other side of the contact that made the source: by an impact (temporary), or by "
        "sliding or rolling (persistent)",
        None,
        optional=True,
    )
    second_position: Vector | None = numbers(
        None,
        "",
        "Position of the source on its second object; default that on the first",
        3,
        unit="m",
        optional=True,
    )
    onset: float = number(
        0.0, "", "When its signal begins; before the first frame, it is negative", -MOST, unit="s"
    )
    priority: float = number(
        1.0,
        "Priority",
        "Weight of this source where a listener mixes by priority",
        0.0,
        soft=(0.0, 10.0),
    )
    extras: Form = extras()
    triggers: tuple[Trigger, ...] | None = part(
        None,
        "trigger",
        "Triggers, each of which plays its signal once; without any, the source is always "
        "active. The signal lasts a minute at most",
        1000,
    )

    def __post_init__(self) -> None:
        if self.second_object is not None and self.second_position is None:
            object.__setattr__(self, "second_position", self.position)
        check(self)
        if self.triggers is not None:
            require_template("signal", self.emitted)

    @property
    def emitted(self) -> Signal:
        """Its signal; without one a tone if it is persistent, or an impact if it is temporary or
        has triggers."""
        if self.signal is not None:
            return self.signal
        hums = self.kind is SourceKind.PERSISTENT and self.triggers is None
        return signals.DEFAULT_PERSISTENT if hums else signals.DEFAULT_IMPACT

    @property
    def rubs(self) -> bool:
        """True for a source of sliding or rolling, which ends with its signal and may begin again
        under its name."""
        return self.kind is SourceKind.PERSISTENT and self.second_object is not None

    def moved(
        self, position: Iterable[float], second_position: Iterable[float] | None = None
    ) -> Source:
        """A copy of this source at another position; the second one stays unless it is given.
        Raises ValueError if a number is not finite."""
        second = (
            self.second_position
            if second_position is None
            else _finite_vector("second_position", second_position)
        )
        return _with(self, position=_finite_vector("position", position), second_position=second)


MIXING = {
    "cumulative": ("Cumulative", "Sums all signals and limits the sum to the ceiling"),
    "weighted": ("Weighted", "Averages the signals by the priorities of their sources"),
    "strongest": ("Strongest", "Only the strongest signal is felt"),
    "power": ("Power", "Adds up energies: the root of the sum of squares"),
    "custom": ("Custom", "Your own formula from the results of the other methods"),
}
"""Methods of mixing."""
FULL_SCALE_UNITS = {
    "m/s^2": ("Acceleration (m/s²)", "As an accelerometer on the device measures it"),
    "N": ("Force (N)", "From which the acceleration of a fingertip's skin is computed"),
}
PARTS = {
    "": ("None", "Not a part of the body"),
    **{
        p.name: (p.name.replace("_", " ").title(), f"Stands for the {p.name.replace('_', ' ')}")
        for p in BODY_PARTS
    },
}


@frozen(slots=False)
class Listener:
    """Receives signals at a point of the body. The fields' declarations say what they are."""

    name: str = field(metadata=name_of("Name, unique among listeners").metadata)
    object: str = field(metadata=name_of("Name of the listener's object").metadata)
    position: Vector = numbers(
        (0.0, 0.0, 0.0), "", "Position of the listener", 3, unit="m", required=True
    )
    body_part: str = choice(
        "", "Body Part", "The place on the body that this listener stands for", PARTS, open=True
    )
    _: KW_ONLY
    radius: float = number(
        0.05,
        "Radius",
        "Radius of the ball that feels: what reaches its nearest point is felt; 0 is a point",
        0.0,
        soft=(0.0, 0.5),
        unit="m",
    )
    mixing: str = choice(
        "cumulative", "Mixing", "How signals that arrive together are combined", MIXING
    )
    mixing_expression: str = text(
        "",
        "Formula",
        "The mix, sample by sample, of sum, weighted, strongest and power (what the other "
        "methods give) and s_max (the ceiling)",
        most=500,
        shown="s_max * tanh(sum / s_max)",
    )
    gain: float = number(
        1.0, "Gain", "Factor of this listener's mixed signal; can be animated", 0.0, soft=(0.0, 2.0)
    )
    s_max: float = number(
        1.0, "Ceiling", "No sample of the mixed signal is stronger than this", 0.0, 1.0, above=True
    )
    limiter: bool = switch(
        False,
        "Limiter",
        "Turns a mix that would exceed the ceiling down, ahead of its peaks, instead of "
        "cutting it off, which distorts. "
        "All listeners then feel 5 ms later",
    )
    full_scale: tuple[tuple[float, float], ...] = curve(
        (),
        "Full Scale",
        "What the device of this listener does at full scale: pairs of hertz and the peak of a "
        "sine there, such as 40 3.2, 160 14. Empty: margins assume that 250 Hz are felt from "
        "-45 dB of full scale on",
        optional=True,
        animated=False,
    )
    full_scale_unit: str = choice(
        "m/s^2", "Unit of Full Scale", "What its numbers are", FULL_SCALE_UNITS, animated=False
    )
    full_scale_source: str = text(
        "", "Calibrated By", "Where the numbers of Full Scale are from", animated=False
    )
    extras: Form = extras()

    def __post_init__(self) -> None:
        check(self)
        if self.mixing == "custom":
            try:
                compile_expression(self.mixing_expression, MIXING_VARIABLES)
            except ValueError as error:
                raise ValueError(
                    f"mixing_expression: {str(error).removeprefix('expression: ')}"
                ) from None

    @property
    def device(self) -> FullScale | None:
        """The calibration of its device; None if margins assume a threshold."""
        is_force = self.full_scale_unit == "N"
        return FullScale(self.full_scale, is_force) if self.full_scale else None

    def moved(self, position: Iterable[float]) -> Listener:
        """A copy of this listener at another position. Raises ValueError if a number is not
        finite."""
        return _with(self, position=_finite_vector("position", position))


@frozen
class HapticScene:
    """Objects, contacts, sources and listeners. Names are unique within their list; every reference
    resolves. ``rules``: settings for contacts and impacts that are found from shapes and poses."""

    objects: tuple[HapticObject, ...] = ()
    contacts: tuple[Contact, ...] = ()
    sources: tuple[Source, ...] = ()
    listeners: tuple[Listener, ...] = ()
    settings: Settings = field(default_factory=Settings)
    extras: Form = field(default_factory=dict, hash=False)
    rules: ContactSettings = field(default_factory=ContactSettings)

    def __post_init__(self) -> None:
        for kind in ("object", "source", "listener"):
            require_unique([item.name for item in getattr(self, f"{kind}s")], kind, f"{kind}s")
        known = {item.name for item in self.objects}
        for i, contact in enumerate(self.contacts):
            for k, name in enumerate(contact.objects):
                require_known(name, known, "object", ("contacts", i, "objects", k))
        for i, source in enumerate(self.sources):
            require_known(source.object, known, "object", ("sources", i, "object"))
            if source.second_object is not None:
                require_known(
                    source.second_object, known, "object", ("sources", i, "second_object")
                )
        for i, listener in enumerate(self.listeners):
            require_known(listener.object, known, "object", ("listeners", i, "object"))
