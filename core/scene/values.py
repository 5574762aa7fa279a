"""The haptic scene as immutable values.

Terms and defaults are those of the Haptic Tracing paper. Lengths in metres, masses in kilograms, times in seconds, amplitudes in [0, 1].
Constructors validate their arguments, so every scene object is valid.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, TypeVar

from .. import signals
from .body import BODY_PARTS
from .choices import Extent as Extent
from .choices import Mode as Mode
from .choices import SourceKind as SourceKind
from .choices import Strategy as Strategy
from .choices import TriggerKind as TriggerKind
from .declaration import check, choice, extras, name_of, number, numbers, switch, text
from .functions import MIXING_VARIABLES, HapticTracing, Identity, ModulationFunction, compile_expression
from .functions.modulation import require
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


def _unit_interval(key: str, value: float) -> None:
    if not 0 <= value <= 1:
        raise ValueError(f"{key}: must lie in [0, 1], got {value!r}")


def _name(key: str, value: str) -> None:
    if not isinstance(value, str) or not value:
        raise ValueError(f"{key}: expected a name, got {value!r}")


_Item = TypeVar("_Item")


def _with(item: _Item, **checked: Any) -> _Item:
    """A copy with other values of some fields. Unlike `dataclasses.replace` it repeats no validation, because positions change in every
    frame."""
    copy = object.__new__(type(item))
    for name in type(item).__slots__:  # type: ignore[attr-defined]
        object.__setattr__(copy, name, checked[name] if name in checked else getattr(item, name))
    return copy


@dataclass(frozen=True, slots=True)
class Settings:
    """Settings of propagation. ``max_connections`` None and ``threshold`` 0 lift the limits; ``tolerance`` is the relative error requested
    of a sum over all paths if its exact value is infeasible (0.01: 1 %). ``localise`` in [0, 1], in mode HT: the gain at all listeners but
    the nearest to each source is multiplied by 1 - localise; at 1 only the nearest feels it."""

    mode: Mode = Mode.HT
    strategy: Strategy = Strategy.AUTO
    max_connections: int | None = 32
    threshold: float = 0.001
    epsilon: float = 0.1
    tolerance: float = 0.01
    localise: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "mode", Mode(self.mode))
        object.__setattr__(self, "strategy", Strategy(self.strategy))
        if self.max_connections is not None:
            if self.max_connections < 0:
                raise ValueError(f"max_connections: must be 0 or more, or None, got {self.max_connections!r}")
            object.__setattr__(self, "max_connections", int(self.max_connections))
        for key in ("threshold", "localise"):
            _unit_interval(key, getattr(self, key))
        for key in ("epsilon", "tolerance"):
            require(key, getattr(self, key))


@dataclass(frozen=True, slots=True)
class Pose:
    """Position in metres and rotation as a quaternion (w, x, y, z), normalised."""

    position: Vector = (0.0, 0.0, 0.0)
    rotation: Quaternion = (1.0, 0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        object.__setattr__(self, "position", _finite_vector("position", self.position))
        rotation = _finite_vector("rotation", self.rotation, 4)
        length = math.hypot(*rotation)
        if length < 1e-12:
            raise ValueError("rotation: a quaternion of length 0 is no rotation")
        # A normalised quaternion keeps all its bits, through any number of files.
        object.__setattr__(self, "rotation", rotation if abs(length - 1) < 1e-12 else tuple(v / length for v in rotation))


@dataclass(frozen=True, slots=True)
class HapticObject:
    """An object that transmits haptic signals. ``kappa`` and ``rho`` in [0, 1]. Contacts are found from ``shape`` (`core.contacts.shapes`)
    and ``pose``. ``impact_material``: key of `IMPACT_MATERIALS` for the signal of its impacts, "" if unknown. ``material``: name of its
    material in the library, for rule tables."""

    name: str
    kappa: float
    rho: float
    propagation: ModulationFunction = field(default_factory=HapticTracing)
    shape: Any = None
    pose: Pose | None = None
    mass: float | None = None
    medium: bool = False
    extras: Mapping[str, Any] = field(default_factory=dict, hash=False)
    motion: Motion = Motion.DYNAMIC
    impact_material: str = ""
    material: str = ""

    def __post_init__(self) -> None:
        _name("name", self.name)
        object.__setattr__(self, "motion", Motion(self.motion))
        if self.impact_material and self.impact_material not in signals.IMPACT_MATERIALS:
            raise ValueError(f"impact_material: {self.impact_material!r} is not one of {', '.join(signals.IMPACT_MATERIALS)}")
        _unit_interval("kappa", self.kappa)
        _unit_interval("rho", self.rho)
        if self.mass is not None and not 0 <= self.mass < math.inf:
            raise ValueError(f"mass: must be finite and >= 0 kg, got {self.mass!r}")


_IDENTITY = Identity()  # one for all contacts: recordings have hundreds of thousands


@dataclass(frozen=True, slots=True)
class Contact:
    """Two touching objects: one contact node on each, ``positions[k]`` on ``objects[k]`` (world, metres).

    Contacts of one pair with a ``share`` below 1 are points of one patch: the graph has one contact at their share-weighted centre.
    ``weight`` multiplies its gain; it is less than 1 if the surfaces are further apart than those of bodies at rest. ``normal`` is a unit
    vector from the first object to the second.
    """

    objects: tuple[str, str]
    positions: tuple[Vector, Vector]
    transmission: ModulationFunction = _IDENTITY
    area: float = 0.0
    normal: Vector = (0.0, 0.0, 1.0)
    depth: float = 0.0
    share: float = 1.0
    weight: float = 1.0
    extras: Mapping[str, Any] = field(default_factory=dict, hash=False)

    def __post_init__(self) -> None:
        first, second = self.objects
        _name("objects", first)
        _name("objects", second)
        if first == second:
            raise ValueError(f"objects: {first!r} can't touch itself")
        object.__setattr__(self, "positions", tuple(_finite_vector("positions", p) for p in self.positions))
        object.__setattr__(self, "normal", _finite_vector("normal", self.normal))
        if not 0 <= self.area < math.inf:
            raise ValueError(f"area: must be finite and >= 0 m^2, got {self.area!r}")
        if not math.isfinite(self.depth):
            raise ValueError(f"depth: must be finite, got {self.depth!r}")
        _unit_interval("share", self.share)
        _unit_interval("weight", self.weight)


@dataclass(frozen=True, slots=True)
class Trigger:
    """What makes a source play its signal once.

    times: at ``times`` [s], each with its strength in [0, 1], 1 without ``strengths``; if ``by`` names the striking objects, strengths are
    fractions of the full energy. hit: impacts of the source's object. passing: the origin of ``object`` enters the box of edges ``size``
    [m] at ``pose``, a plane if one of them is 0. level: ``value`` rises above 0; files store the times.
    """

    on: TriggerKind
    times: tuple[float, ...] = ()
    strengths: tuple[float, ...] = ()
    by: tuple[str, ...] = ()
    object: str = ""
    pose: Pose = field(default_factory=Pose)
    size: Vector = (0.0, 0.0, 0.0)
    value: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "on", TriggerKind(self.on))
        object.__setattr__(self, "size", _finite_vector("size", self.size))
        if not all(map(math.isfinite, self.times)):
            raise ValueError("times: must be finite")
        for key in ("strengths", "by"):
            if getattr(self, key) and len(getattr(self, key)) != len(self.times):
                raise ValueError(f"{key}: expected as many as there are times")
        for strength in self.strengths:
            _unit_interval("strengths", strength)
        if self.on is TriggerKind.PASSING:
            _name("object", self.object)
            if min(self.size) < 0:
                raise ValueError(f"size: must be 0 or more, got {self.size!r}")


@dataclass(frozen=True, slots=True)
class Source:
    """Emits a signal. A source of an impact, or of sliding or rolling, also excites ``second_object``, the other side of its contact. A
    source with ``triggers`` plays its signal only once per trigger; None: it plays without triggers."""

    name: str
    object: str
    position: Vector = (0.0, 0.0, 0.0)
    amplitude: float = 1.0
    kind: SourceKind = SourceKind.PERSISTENT
    signal: Signal | None = None
    second_object: str | None = None
    second_position: Vector | None = None
    onset: float = 0.0
    priority: float = 1.0
    extras: Mapping[str, Any] = field(default_factory=dict, hash=False)
    triggers: tuple[Trigger, ...] | None = None

    def __post_init__(self) -> None:
        _name("name", self.name)
        _name("object", self.object)
        object.__setattr__(self, "kind", SourceKind(self.kind))
        object.__setattr__(self, "position", _finite_vector("position", self.position))
        _unit_interval("amplitude", self.amplitude)
        if self.second_object is not None:
            object.__setattr__(self, "second_position", _finite_vector("second_position", self.second_position or self.position))
        if self.triggers is not None:
            require_template("signal", self.emitted)

    @property
    def emitted(self) -> Signal:
        """Its signal; without one a tone if it is persistent, or an impact if it is temporary or has triggers."""
        if self.signal is not None:
            return self.signal
        hums = self.kind is SourceKind.PERSISTENT and self.triggers is None
        return signals.DEFAULT_PERSISTENT if hums else signals.DEFAULT_IMPACT

    @property
    def rubs(self) -> bool:
        """True for a source of sliding or rolling, which ends with its signal and may begin again under its name."""
        return self.kind is SourceKind.PERSISTENT and self.second_object is not None

    def moved(self, position: Iterable[float], second_position: Iterable[float] | None = None) -> Source:
        """The same source elsewhere; its second position is kept unless it is given. Raises ValueError if a number is not finite."""
        second = self.second_position if second_position is None else _finite_vector("second_position", second_position)
        return _with(self, position=_finite_vector("position", position), second_position=second)


MIXING = {
    "cumulative": ("Cumulative", "Sums all signals and limits the sum to the ceiling"),
    "weighted": ("Weighted", "Averages the signals by the priorities of their sources"),
    "strongest": ("Strongest", "Only the strongest signal is felt"),
    "power": ("Power", "Adds up energies: the root of the sum of squares"),
    "custom": ("Custom", "Your own formula from the results of the other methods"),
}
"""Methods of mixing."""
EXTENTS = {
    Extent.NONE: ("Point", "Feels what arrives at its origin, whatever the radius"),
    Extent.STRONGEST: ("Strongest", "Contacts within the radius count as if they were at the origin"),
    Extent.MEAN_POWER: ("Mean Power", "Feels the mean of the power over its volume"),
}
PARTS = {
    "": ("None", "Not a part of the body"),
    **{p.name: (p.name.replace("_", " ").title(), f"Stands for the {p.name.replace('_', ' ')}") for p in BODY_PARTS},
}


@dataclass(frozen=True, slots=True)
class Listener:
    """Receives signals at a point of the body. The fields' declarations say what they are."""

    name: str = field(metadata=name_of("Name, unique among listeners"))
    object: str = field(metadata=name_of("Name of the listener's object"))
    position: Vector = field(default=(0.0, 0.0, 0.0), metadata=numbers("", "Position of the listener", 3, unit="m", required=True))
    body_part: str = field(
        default="", metadata=choice("Body Part", "The place on the body that this listener stands for", PARTS, open=True)
    )
    extent: Extent = field(
        default=Extent.NONE,
        metadata=choice(
            "Extent",
            "What the listener feels of its bounding volume. New listeners feel the strongest; those of earlier files are points",
            EXTENTS,
        ),
    )
    radius: float = field(
        default=0.05, metadata=number("Radius", "Radius of the listener's bounding volume", 0.0, soft=(0.0, 0.5), unit="m")
    )
    mixing: str = field(default="cumulative", metadata=choice("Mixing", "How signals that arrive together are combined", MIXING))
    mixing_expression: str = field(
        default="",
        metadata=text(
            "Formula",
            "The mix, sample by sample, of sum, weighted, strongest and power (what the other methods give) and s_max (the ceiling)",
            most=500,
            shown="s_max * tanh(sum / s_max)",
        ),
    )
    ducking: float = field(
        default=0.0,
        metadata=number(
            "Ducking",
            "Sources are turned down by so many decibels while one of higher priority arrives here",
            0.0,
            60.0,
            soft=(0.0, 24.0),
            unit="dB",
        ),
    )
    gain: float = field(
        default=1.0, metadata=number("Gain", "Factor of this listener's mixed signal; can be animated", 0.0, soft=(0.0, 2.0))
    )
    s_max: float = field(
        default=1.0, metadata=number("Ceiling", "No sample of the mixed signal is stronger than this", 0.0, 1.0, above=True)
    )
    limiter: bool = field(
        default=False,
        metadata=switch(
            "Limiter",
            "Turns a mix that would exceed the ceiling down, ahead of its peaks, instead of cutting it off, which distorts. "
            "All listeners then feel 5 ms later",
        ),
    )
    extras: Mapping[str, Any] = extras()

    def __post_init__(self) -> None:
        check(self)
        if self.mixing == "custom":
            try:
                compile_expression(self.mixing_expression, MIXING_VARIABLES)
            except ValueError as error:
                raise ValueError(f"mixing_expression: {str(error).removeprefix('expression: ')}") from None

    def moved(self, position: Iterable[float]) -> Listener:
        """The same listener elsewhere. Raises ValueError if a number is not finite."""
        return _with(self, position=_finite_vector("position", position))


@dataclass(frozen=True, slots=True)
class HapticScene:
    """Objects, contacts, sources and listeners. Names are unique within their list; every reference resolves. ``rules``: settings for
    contacts and impacts that are found from shapes and poses."""

    objects: tuple[HapticObject, ...] = ()
    contacts: tuple[Contact, ...] = ()
    sources: tuple[Source, ...] = ()
    listeners: tuple[Listener, ...] = ()
    settings: Settings = field(default_factory=Settings)
    extras: Mapping[str, Any] = field(default_factory=dict, hash=False)
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
                require_known(source.second_object, known, "object", ("sources", i, "second_object"))
            for k, trigger in enumerate(source.triggers or ()):
                if trigger.on is TriggerKind.PASSING:
                    require_known(trigger.object, known, "object", ("sources", i, "triggers", k, "object"))
        for i, listener in enumerate(self.listeners):
            require_known(listener.object, known, "object", ("listeners", i, "object"))
