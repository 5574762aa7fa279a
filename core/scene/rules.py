"""Settings of motion, contacts and impacts."""

from __future__ import annotations

import enum
from collections.abc import Iterable
from dataclasses import field
from functools import lru_cache

from ..declaration import Declared, check, choice, number, numbers, part, switch
from ..frozen import frozen
from .functions import ModulationFunction, require_gains
from .impact_rule import FULL_ENERGY, LEAST_ENERGY, REFRACTORY, TEMPLATES, ImpactLimits, ImpactRule
from .impact_rule import ImpactTemplates as ImpactTemplates
from .joint import Joint
from .rule_table import MOST_ROWS, RuleTable
from .texture import Texture

# The same ones for every impact.
_plain_rule = lru_cache(maxsize=8)(ImpactRule)
_limits = lru_cache(maxsize=64)(ImpactLimits)
_ROWS = ": of the rows that match a pair, the most specific one applies; default none"


class Motion(enum.StrEnum):
    """What moves a body."""

    STATIC = "static"  # nothing
    KINEMATIC = "kinematic"  # animation
    DYNAMIC = "dynamic"  # the simulation


class ImpactEnergy(enum.StrEnum):
    """The energy that is compared with an impact's limits."""

    # 1/2 m v^2 of the relative motion along the normal, with the effective mass of both bodies at
    # the contact: the same in every frame of reference.
    EFFECTIVE = "effective"
    AS_IN_THE_PAPER = "as_in_the_paper"  # 1/2 m1 v1^2 + 1/2 m2 v2^2, and what turns


ENERGIES = {
    ImpactEnergy.EFFECTIVE: (
        "Of the Blow",
        "Energy of the surfaces' motion towards each other, with the masses that are felt there",
    ),
    ImpactEnergy.AS_IN_THE_PAPER: (
        "As in the Paper",
        "Kinetic energy of both objects: ½ m₁ v₁² + ½ m₂ v₂², and that of their rotation",
    ),
}

_LEAST = {ImpactEnergy.EFFECTIVE: 0.05, ImpactEnergy.AS_IN_THE_PAPER: 5.0}
"""The default least energy of each kind [J]."""

PAPER_FULL_ENERGY = 100.0
"""The full energy of the paper, and of a scene in which nothing that moves has a mass [J]."""

_FALL = 9.81 * 0.5
"""Energy per mass of a fall of half a metre [J/kg]."""


def full_energy_of(masses: Iterable[float]) -> float:
    """The energy [J] of full strength in a scene in which bodies of these ``masses`` [kg] move:
    that of the heaviest one after a fall of half a metre."""
    return max(masses, default=0.0) * _FALL or PAPER_FULL_ENERGY


@frozen
class ContactSettings(Declared):
    """Settings of contacts and impacts. A pair begins to touch at the signed distance
    ``tolerance``, and parts at one larger by ``slack``. ``gravity`` accelerates dynamic bodies if
    too few frames show their fall. Without a matching row in a table, an impact plays the
    ``templates`` within `limits`, a contact has gain 1, and nothing sounds that slides or rolls."""

    tolerance: float = number(
        0.01,
        "Contact Tolerance",
        "Objects closer than this touch",
        0.0,
        soft=(0.0, 0.1),
        unit="m",
        digits=4,
    )
    slack: float = number(
        0.005, "", "Distance beyond the tolerance up to which a contact persists", 0.0, unit="m"
    )
    impacts: bool = switch(
        True, "Impacts", "Collisions make temporary sources that play the impact signal once"
    )
    templates: ImpactTemplates = choice(
        ImpactTemplates.PLAIN, "", "What impacts feel like", TEMPLATES
    )
    least_energy: float | None = field(default=None, metadata=LEAST_ENERGY)
    full_energy: float | None = field(default=None, metadata=FULL_ENERGY)
    energy: ImpactEnergy = choice(
        ImpactEnergy.EFFECTIVE, "Energy", "The energy that a collision is judged by", ENERGIES
    )
    refractory: float = field(default=0.1, metadata=REFRACTORY)
    gravity: tuple[float, float, float] = numbers(
        (0.0, 0.0, -9.81), "", "Acceleration of dynamic objects that fall", 3, unit="m/s^2"
    )
    time_scale: float = number(
        1.0, "", "Seconds of simulation in a second of the scene", 0.0, above=True
    )
    passing: tuple[tuple[str, str], ...] = part(
        (),
        "pair",
        "Pairs of objects that pass through each other without impacts, sliding or rolling; "
        "default none",
        1_000_000,
    )
    joints: tuple[Joint, ...] = part(
        (), "joint", "Pivots that hold two objects together; default none", 1_000_000
    )
    impact_table: RuleTable[ImpactRule] = part(
        RuleTable(),
        "impact_rule",
        f"Rules of impacts between some objects, instead of those above{_ROWS}",
        MOST_ROWS,
    )
    transmission_table: RuleTable[ModulationFunction] = part(
        RuleTable(),
        "transmission_rule",
        f"Transmission functions of contacts that are found between some objects{_ROWS} (gain 1)",
        MOST_ROWS,
    )
    textures: RuleTable[Texture] = part(
        RuleTable(),
        "texture",
        f"Textures of objects that slide or roll on each other{_ROWS} (silent)",
        MOST_ROWS,
    )

    def __post_init__(self) -> None:
        check(self)
        for row in self.transmission_table.rows:
            require_gains(row.value, on_contact=True)

    @property
    def limits(self) -> ImpactLimits:
        """The limits of impacts without a matching rule."""
        return self._known(_limits(self.least_energy, self.full_energy, self.refractory))

    def _known(self, limits: ImpactLimits) -> ImpactLimits:
        """Limits with the values of this kind of energy in place of unknown ones; the full energy
        may still be that of the scene, None."""
        least, full = limits.least_energy, limits.full_energy
        if full is None and self.energy is ImpactEnergy.AS_IN_THE_PAPER:
            full = PAPER_FULL_ENERGY
        return _limits(_LEAST[self.energy] if least is None else least, full, limits.refractory)

    def impact_rules(self) -> tuple[ImpactRule, ...]:
        """The rule for pairs without a matching row, and those of all rows."""
        return _plain_rule(self.templates), *(row.value for row in self.impact_table.rows)

    def all_limits(self) -> tuple[ImpactLimits, ...]:
        """The limits of all impact rules."""
        return self.limits, *(
            self._known(rule.limits) for rule in self.impact_rules() if rule.limits is not None
        )

    def impact_rule(self, first: tuple[str, str], second: tuple[str, str]) -> ImpactRule:
        """The rule for impacts of two objects, each given by name and material."""
        return self.impact_table.of(first, second) or _plain_rule(self.templates)

    def impact_limits(self, first: tuple[str, str], second: tuple[str, str]) -> ImpactLimits:
        """The limits for impacts of two objects."""
        limits = self.impact_rule(first, second).limits
        return self.limits if limits is None else self._known(limits)
