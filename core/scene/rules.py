"""Settings of motion, contacts and impacts."""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass, field
from functools import lru_cache

from .functions import ModulationFunction
from .functions.modulation import require
from .impact_rule import ImpactLimits, ImpactRule
from .impact_rule import ImpactTemplates as ImpactTemplates
from .rule_table import RuleTable
from .texture import Texture

# The same ones for every impact.
_plain_rule = lru_cache(maxsize=8)(ImpactRule)
_limits = lru_cache(maxsize=64)(ImpactLimits)


class Motion(enum.StrEnum):
    """What moves a body."""

    STATIC = "static"  # nothing
    KINEMATIC = "kinematic"  # animation
    DYNAMIC = "dynamic"  # the simulation


class ImpactEnergy(enum.StrEnum):
    """The energy that is compared with an impact's limits."""

    KINETIC = "kinetic"  # the paper's: 1/2 m1 v1^2 + 1/2 m2 v2^2
    NORMAL = "normal"  # 1/2 mu v_n^2: relative motion along the normal, the same in every frame of reference


@dataclass(frozen=True, slots=True)
class ContactSettings:
    """``tolerance`` [m]: a pair begins to touch at this signed distance, and parts at a distance larger by ``slack`` [m].

    An impact is a new contact with at least ``least_energy`` (E_min) joules; ``full_energy`` (E_max) gives amplitude 1; ``energy`` says how
    it is computed. A pair has no second impact within ``refractory`` seconds. ``gravity`` [m/s^2] accelerates dynamic bodies if too few
    frames show their fall; ``time_scale``: simulated seconds per second of the timeline. ``impacts``: impacts make temporary sources, which
    play the ``templates``, or the values of the matching row of ``impact_table``. ``transmission_table``: transmission functions of the
    contacts that are found; gain 1 without a matching row. ``textures``: textures of pairs that slide or roll; none without a matching row.
    """

    tolerance: float = 0.01
    slack: float = 0.005
    energy: ImpactEnergy = ImpactEnergy.KINETIC
    least_energy: float = 5.0
    full_energy: float = 100.0
    refractory: float = 0.1
    gravity: tuple[float, float, float] = (0.0, 0.0, -9.81)
    time_scale: float = 1.0
    impacts: bool = True
    templates: ImpactTemplates = ImpactTemplates.PLAIN
    impact_table: RuleTable[ImpactRule] = field(default_factory=RuleTable)
    transmission_table: RuleTable[ModulationFunction] = field(default_factory=RuleTable)
    textures: RuleTable[Texture] = field(default_factory=RuleTable)

    def __post_init__(self) -> None:
        object.__setattr__(self, "energy", ImpactEnergy(self.energy))
        object.__setattr__(self, "templates", ImpactTemplates(self.templates))
        for key in ("tolerance", "slack"):
            require(key, getattr(self, key))
        if not 0 < self.time_scale < math.inf:
            raise ValueError(f"time_scale: must be finite and > 0, got {self.time_scale!r}")
        assert self.limits  # which are checked when they are made
        gravity = tuple(float(g) for g in self.gravity)
        if len(gravity) != 3 or not all(math.isfinite(g) for g in gravity):
            raise ValueError(f"gravity: expected three finite numbers, got {self.gravity!r}")
        object.__setattr__(self, "gravity", gravity)

    @property
    def limits(self) -> ImpactLimits:
        """The limits of impacts without a matching rule."""
        return _limits(self.least_energy, self.full_energy, self.refractory)

    def impact_rules(self) -> tuple[ImpactRule, ...]:
        """The rule for pairs without a matching row, and those of all rows."""
        return _plain_rule(self.templates), *(row.does for row in self.impact_table.rows)

    def all_limits(self) -> tuple[ImpactLimits, ...]:
        """The limits of all impact rules."""
        return self.limits, *(rule.limits for rule in self.impact_rules() if rule.limits is not None)

    def impact_rule(self, first: tuple[str, str], second: tuple[str, str]) -> ImpactRule:
        """The rule for impacts of two objects, each given by name and material."""
        return self.impact_table.of(first, second) or _plain_rule(self.templates)

    def impact_limits(self, first: tuple[str, str], second: tuple[str, str]) -> ImpactLimits:
        """The limits for impacts of two objects."""
        return self.impact_rule(first, second).limits or self.limits
