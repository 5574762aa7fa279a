"""Checks of the four modes: properties that hold by definition, and measured differences.

The paper gives no numbers for any of this; its results are ratings, which cannot be computed
(`FINDINGS`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations

import numpy as np

from ..core.arrays import BoolArray, FloatArray
from ..core.frozen import frozen
from ..core.graph.distance_only import DISTANCE_ONLY
from ..core.perception import are_felt_alike, are_felt_different
from ..core.scene.values import Mode
from .measures import WINDOW, balance, dynamic_range, patterns, variety
from .rendition import MODES, ActiveSource, Ride

HT, SD, MD, MN = range(4)
"""Rows of `ActiveSource.amplitudes`."""

SECTION_COUNT = 6
MATERIALS = ("Stone", "Wood", "Ribbon")
ROUNDING = 1e-6
"""Relative tolerance, for Blender's transforms in single precision."""


@frozen
class Check:
    """A statement, the measurement in words, and whether it holds; None if the frames contain
    nothing to measure."""

    name: str
    statement: str
    measured: str
    holds: bool | None
    by_definition: bool = False

    @classmethod
    def without_data(cls, name: str, statement: str) -> Check:
        """The check for frames without the event of the statement."""
        return cls(name, statement, "not in these frames", None)


def checks_of(ride: Ride) -> tuple[Check, ...]:
    """All checks: by definition, then by measurement."""
    definitions = (
        single_actuator(ride),
        nearest_actuator(ride),
        all_alike(ride),
        distance_only(ride),
        alike_by_material(ride, Mode.MD),
        alike_by_material(ride, Mode.MN),
        one_leg(ride),
        no_direction(ride),
    )
    return (*(replace(check, by_definition=True) for check in definitions), *measured_checks(ride))


def measured_checks(ride: Ride) -> tuple[Check, ...]:
    """The checks that depend on the scene's values, by section at the end."""
    sections = [
        check
        for section in ride.sections
        for check in (has_pattern(ride, section), wider_than_distance(ride, section))
    ]
    return (
        differs_by_material(ride),
        both_legs(ride),
        left_to_right(ride),
        wider_range(ride),
        *sections,
    )


def single_actuator(ride: Ride) -> Check:
    """At most one actuator per source in SD."""
    name, statement = "SD: one at a time", "A source drives a single actuator."
    if not ride.soundings:
        return Check.without_data(name, statement)
    most = max(int((s.amplitudes[SD] > 0).sum()) for s in ride.soundings)
    return Check(
        name, statement, f"at most {most} in {len(ride.soundings)} source frames", most == 1
    )


def nearest_actuator(ride: Ride) -> Check:
    """SD drives the actuator nearest to the source."""
    name, statement = "SD: the nearest", "The driven actuator is the one nearest to the source."
    driven = [s for s in ride.soundings if s.amplitudes[SD].any()]
    if not driven:
        return Check.without_data(name, statement)
    further = [float(s.distance[s.amplitudes[SD].argmax()] - s.distance.min()) for s in driven]
    return Check(
        name,
        statement,
        f"never more than {max(further) * 1000:.3f} mm further than the nearest",
        max(further) < 1e-9,
    )


def all_alike(ride: Ride) -> Check:
    """All actuators have the same signal in MN."""
    name, statement = "MN: all alike", "All actuators are driven alike, sample by sample."
    if not ride.soundings:
        return Check.without_data(name, statement)
    others = ", ".join(f"{mode} {ride.largest_difference[mode]:.3f}" for mode in MODES[:3])
    value = ride.largest_difference[Mode.MN]
    return Check(
        name,
        statement,
        f"largest difference between two actuators {value:g} of full scale ({others})",
        value == 0.0,
    )


def distance_only(ride: Ride) -> Check:
    """Gains in MD are those of the paper's equation 4 at the straight distance."""
    name, statement = (
        "MD: by distance only",
        f"Every gain is e^(-{DISTANCE_ONLY.alpha:g} d) of the source, whatever lies between.",
    )
    if not ride.soundings:
        return Check.without_data(name, statement)
    worst = 0.0
    for s in ride.soundings:
        expected = s.amplitude * np.exp(-DISTANCE_ONLY.alpha * s.distance)
        worst = max(worst, float(np.abs(s.amplitudes[MD] / expected - 1).max()))
    return Check(name, statement, f"largest relative error {worst:.1e}", worst <= ROUNDING)


def wall_amplitudes(ride: Ride) -> dict[str, FloatArray]:
    """By wall, in the order of the ride: (4, l) the sum of the amplitudes of its impacts at each
    listener, by `MODES`."""
    walls: dict[str, FloatArray] = {}
    for s in ride.soundings:
        for name in s.objects if s.began else ():
            if name.partition(" Wall ")[0] in MATERIALS:
                walls[name] = walls.get(name, 0.0) + s.amplitudes
    return walls


def wall_margins(ride: Ride) -> dict[str, tuple[FloatArray, float]]:
    """By wall: the highest margins (l,) in HT from its first impact until a quarter second after
    its last, and the lowest frequency of its impacts."""
    impacts: dict[str, list[ActiveSource]] = {}
    for s in ride.soundings:
        for name in s.objects if s.began else ():
            if name.partition(" Wall ")[0] in MATERIALS:
                impacts.setdefault(name, []).append(s)
    after = round(WINDOW * ride.frame_rate)
    margin = ride.renditions[Mode.HT].margin
    return {
        name: (
            margin[ride.rows(own[0].frame, own[-1].frame + after)].max(axis=0),
            min(s.hertz for s in own),
        )
        for name, own in impacts.items()
    }


def walls_felt(ride: Ride, mode: int) -> dict[str, list[FloatArray]]:
    """By material: amplitudes (l,) of each wall in a mode."""
    felt: dict[str, list[FloatArray]] = {}
    for name, amplitudes in wall_amplitudes(ride).items():
        felt.setdefault(name.partition(" Wall ")[0], []).append(amplitudes[mode])
    return felt


def _difference(walls: Sequence[FloatArray]) -> float:
    """The largest difference in decibels between amplitudes (l,) of walls at an actuator; infinite
    if only some are felt there."""
    lowest, highest = np.min(walls, axis=0), np.max(walls, axis=0)
    with np.errstate(divide="ignore"):
        return float(20 * np.log10(highest[highest > 0] / lowest[highest > 0]).max(initial=0.0))


def felt_anywhere(ride: Ride) -> tuple[dict[str, BoolArray], float]:
    """By material: the actuators (l,) at which one of its walls is felt in HT; and the lowest
    frequency of the impacts."""
    felt: dict[str, BoolArray] = {}
    lowest = np.inf
    for name, (margin, hertz) in wall_margins(ride).items():
        material = name.partition(" Wall ")[0]
        felt[material] = felt.get(material, np.zeros(len(margin), dtype=np.bool_)) | (margin > 0)
        lowest = min(lowest, hertz)
    return felt, float(lowest)


def differs_by_material(ride: Ride) -> Check:
    """In HT walls of different materials differ more than those of the same, where they are
    felt."""
    name, statement = (
        "HT: by material",
        "Walls of stone, wood and ribbons are felt differently, those of one material alike.",
    )
    walls = walls_felt(ride, HT)
    if len(walls) < len(MATERIALS):
        return Check.without_data(name, statement)
    felt, hertz = felt_anywhere(ride)
    within = max(_difference(group) for group in walls.values())
    pairs, apart = [], []
    for one, other in combinations(walls, 2):
        somewhere = felt[one] | felt[other]
        means = [np.mean(walls[kind], axis=0)[somewhere] for kind in (one, other)]
        each = [
            _difference([a, b]) for a, b in zip(*(mean[:, None] for mean in means), strict=True)
        ]
        count = sum(are_felt_different(decibels, hertz) for decibels in each)
        apart.append(count > 0)
        pairs.append(
            f"{one.lower()} and {other.lower()} {max(each, default=0.0):.1f} dB, noticed by most "
            f"at {count} of {int(somewhere.sum())} actuators that feel either"
        )
    measured = f"{'; '.join(pairs)}; walls of one {within:.2f} dB or less (at {hertz:.0f} Hz)"
    return Check(name, statement, measured, all(apart) and are_felt_alike(within, hertz))


def alike_by_material(ride: Ride, mode: Mode) -> Check:
    """In MD and MN all walls have the same amplitudes."""
    name, statement = f"{mode}: whatever the material", "All nine walls are felt alike."
    felt = walls_felt(ride, MODES.index(mode))
    if len(felt) < len(MATERIALS):
        return Check.without_data(name, statement)
    difference = _difference([amplitudes for group in felt.values() for amplitudes in group])
    return Check(
        name,
        statement,
        f"largest difference between two walls at an actuator {difference:.2f} dB",
        are_felt_alike(difference, felt_anywhere(ride)[1]),
    )


def stalactites(ride: Ride) -> tuple[ActiveSource, ...]:
    """The impacts of stalactites, one each."""
    return ride.began("Stalactite")


def legs_of(ride: Ride) -> list[int]:
    """Columns of the left and the right upper leg."""
    return [ride.listeners.index(f"upper_leg.{side}") for side in "LR"]


def both_legs(ride: Ride) -> Check:
    """In HT a falling stalactite is felt in both legs, through the ground and the rails."""
    name, statement = (
        "HT: both legs",
        "A stalactite that falls is felt in both legs alike, through the ground.",
    )
    falls = stalactites(ride)
    if not falls:
        return Check.without_data(name, statement)
    legs = legs_of(ride)
    difference = max(
        _difference([s.amplitudes[HT][[legs[0]]], s.amplitudes[HT][[legs[1]]]]) for s in falls
    )
    margins = np.array([s.margins[HT][legs] for s in falls])
    felt = int((margins > 0).all(axis=1).sum())
    ways = [s.paths[leg] for s in falls for leg in legs]
    through = sum(any(part.startswith(("Ground", "Bridge")) for part in way) for way in ways)
    measured = (
        f"{felt} of {len(falls)} stalactites felt in both legs, the strongest "
        f"{margins.max():+.1f} dB above the threshold; legs differ by {difference:.2f} dB or less; "
        f"{through} of {len(ways)} paths by the ground"
    )
    alike = all(are_felt_alike(difference, s.hertz) for s in falls)
    holds = felt == len(falls) and alike and through == len(ways)
    return Check(name, statement, measured, holds)


def one_leg(ride: Ride) -> Check:
    """In SD a falling stalactite is felt in one place."""
    name, statement = "SD: one place", "A stalactite that falls is felt at one actuator."
    falls = stalactites(ride)
    if not falls:
        return Check.without_data(name, statement)
    most = max(int((s.amplitudes[SD] > 0).sum()) for s in falls)
    return Check(name, statement, f"at most {most} actuator", most <= 1)


def shock_rows(ride: Ride) -> slice | None:
    """The frames in which the shock wave is felt, None if they are not in the range."""
    hits = [s.frame for s in ride.began("Shock Front")]
    return ride.rows(min(hits), max(hits)) if hits else None


def shock_balance(ride: Ride, mode: Mode) -> tuple[float, float] | None:
    """Left-right balance in the first and in the last third of the shock wave's passage."""
    rows = shock_rows(ride)
    if rows is None or rows.stop - rows.start < 3:
        return None
    values = balance(ride.renditions[mode].rms[rows], ride.listeners)
    third = len(values) // 3
    return float(values[:third].mean()), float(values[-third:].mean())


def left_to_right(ride: Ride) -> Check:
    """In HT the shock wave goes from left to right."""
    name, statement = (
        "HT: from left to right",
        "The shock wave begins on the left and ends on the right.",
    )
    found = shock_balance(ride, Mode.HT)
    if found is None:
        return Check.without_data(name, statement)
    measured = f"balance {found[0]:+.2f} in its first third, {found[1]:+.2f} in its last"
    return Check(name, statement, measured, found[0] < -0.1 and found[1] > 0.1)


def no_direction(ride: Ride) -> Check:
    """In MN the shock wave has no direction."""
    name, statement = "MN: no direction", "The shock wave is on both sides alike."
    found = shock_balance(ride, Mode.MN)
    if found is None:
        return Check.without_data(name, statement)
    return Check(
        name, statement, f"balance {found[0]:+.2f} and {found[1]:+.2f}", found == (0.0, 0.0)
    )


def wider_range(ride: Ride) -> Check:
    """HT has a wider range and more entropy of intensity than the other modes that drive many
    actuators."""
    name, statement = (
        "HT: more shades",
        "Of those that drive many actuators, HT has the widest range and variety of what is felt, "
        "all at equal mean loudness.",
    )
    if len(ride.sections) < SECTION_COUNT:
        return Check.without_data(name, statement)
    margins = {mode: ride.margins(mode) + ride.equalising_gain(mode) for mode in MODES}
    ranges = {mode: dynamic_range(values) for mode, values in margins.items()}
    bits = {mode: variety(values) for mode, values in margins.items()}
    measured = "; ".join(
        f"{mode} {ranges[mode]:.1f} dB, {bits[mode]:.2f} bits"
        for mode in (Mode.HT, Mode.MD, Mode.MN)
    )
    holds = all(
        ranges[Mode.HT] > ranges[mode] and bits[Mode.HT] > bits[mode] for mode in (Mode.MD, Mode.MN)
    )
    return Check(name, statement, measured, holds)


SectionFrames = tuple[str, str, int, int]
"""Name, title, first and last frame."""


def has_pattern(ride: Ride, section: SectionFrames) -> Check:
    """Whether HT has a spatial pattern in a section."""
    _, title, first, last = section
    name, statement = (
        f"{title}: a pattern",
        "In HT some effect is felt at two actuators so differently that most people notice, or at "
        "one so much and at another not at all.",
    )
    effects = ride.effects(first, last)
    if not effects:
        return Check.without_data(name, statement)
    felt = [(np.maximum(s.margins[HT], 0.0), s.hertz) for s in effects if (s.margins[HT] > 0).any()]
    apart = sum(are_felt_different(float(np.ptp(margin)), hertz) for margin, hertz in felt)
    bits = patterns(ride.margins(Mode.HT, first, last))
    measured = (
        f"{apart} of {len(felt)} effects felt ({len(effects)} in all); {bits:.2f} bits of patterns"
    )
    return Check(name, statement, measured, apart > 0)


def wider_than_distance(ride: Ride, section: SectionFrames) -> Check:
    """Whether what is felt in HT has a wider range than in MD in a section."""
    _, title, first, last = section
    name, statement = (
        f"{title}: more range",
        "What is felt in HT ranges further than by distance alone.",
    )
    margins = [ride.margins(mode, first, last) for mode in (Mode.HT, Mode.MD)]
    if not margins[0].size:
        return Check.without_data(name, statement)
    ranges = [dynamic_range(values) for values in margins]
    return Check(
        name, statement, f"HT {ranges[0]:.1f} dB, MD {ranges[1]:.1f} dB", ranges[0] > ranges[1]
    )


FINDINGS = (
    (
        "Preferred rendering",
        "HT 19, MD 10, MN 8, SD 4 people (their sum is 41; one of the 41 was left out of the "
        "analysis)",
    ),
    (
        "Realism",
        "differs between the modes: Friedman, chi-square(3, 40) = 15.5, p < 0.01; SD below MD "
        "and HT",
    ),
    (
        "Expressivity",
        "differs between the modes: Friedman, chi-square(3, 40) = 14.1, p < 0.01; HT above MN "
        "and MD, SD above MN",
    ),
    ("Harmony, involvement", "no significant difference"),
)
"""The paper's results from questionnaires, with its numbers."""

LIMITS = (
    "Felt means above the threshold of feeling, which is assumed: 45 dB below full scale at 250 "
    "Hz, as no device was measured. 10 dB more or less change most verdicts.",
    "Most people notice a difference: three of four do, whichever published threshold holds at "
    "that frequency (medians of 1.65 to 3.97 dB below 40 Hz, 1.58 to 2.98 dB above, at fingertip, "
    "thenar and forearm, 10 to 35 dB above the threshold of feeling). People's Weber fractions are "
    "assumed to spread by a factor of 1.5: no source that could be read gives it. Thighs, back and "
    "ears feel less well, and just above the threshold of feeling differences of up to 20 dB go "
    "unnoticed.",
    "κ and ρ of the library's materials are chosen by design, so that neighbours differ; none is "
    "tuned for the ride. Measured "
    "materials stand beside them.",
    "Places, masses and sources of the ride were arranged so that sections show what the paper "
    "describes: stalactites fall close to the "
    "cart, the wind reaches the legs only, carts cross at 2.8 m, 40 J count as a blow of full "
    "strength where the paper has 100. The air of the wind fades by "
    "0.35 per metre, which is chosen: the library has no damping of air that a skin would notice. "
    "--sensitivity varies them.",
    "The ride is a scene of its own with the sections that the paper describes: the paper's "
    "geometry and signals are not public.",
    "Contacts are those that the ride's own values reach: a variation that lets vibration go "
    "further may miss some.",
)
"""Limits of these numbers."""
