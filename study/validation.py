"""Comparison of the model with published measurements and printed solutions.

Levels are amplitudes in decibels relative to the first place of a series. Places used for a fit are
not judged. Every series says what in the model was chosen with it. Held out are those of which
nothing was, and whose numbers were read in their source or a transcription of it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import combinations, pairwise

import numpy as np

from ..core.arrays import FloatArray
from ..core.contacts.contact_set import ContactSet
from ..core.frozen import frozen
from ..core.graph.haptic_graph import ObjectTable
from ..core.graph.impedances import passed_by_bodies
from ..core.graph.object_frames import ObjectFrames
from ..core.perception import FullScale, threshold_level
from ..core.run_time import Scene
from ..core.scene.bands import BAND_CENTRES, BAND_EDGES
from ..core.scene.functions import HapticTracing, Impedance, Physical, Wave
from ..core.scene.materials import MATERIALS
from ..core.scene.measured import DAMPING, physical
from ..core.scene.values import (
    Contact,
    HapticObject,
    HapticScene,
    Listener,
    Source,
    Vector,
)

NEPER = 20 / math.log(10)
CLOSE = 3.0
"""Largest accepted error of a ground model [dB]."""

HALL, HALL_LEVELS = [13.0, 23.0, 43.0, 73.0], [0.0, -4.2, -13.8, -29.3]
"""Distances [m] outside a machine hall, and levels [dB] there."""
HALL_FREQUENCIES = (30.0, 40.0, 50.0)
"""Frequencies [Hz] at which the library's soil is compared with them."""
FOUNDATION_HERTZ = (4, 5, 6.3, 8, 10, 12.5, 16, 20, 25, 31.5, 40, 50, 63, 80)
FOUNDATIONS = {
    "basement": (
        -4.0,
        -3.5,
        -3.6,
        -4.2,
        -4.2,
        -3.8,
        -4.6,
        -6.0,
        -8.2,
        -9.3,
        -7.4,
        -5.1,
        -4.4,
        -4.2,
    ),
    "ground floor": (
        -3.2,
        -3.0,
        -3.9,
        -3.0,
        -2.2,
        -1.9,
        -3.1,
        -4.2,
        -5.8,
        -6.4,
        -5.7,
        -4.9,
        -5.3,
        -4.7,
    ),
}
"""Level [dB] of a foundation relative to the ground, mean over buildings, by frequency."""
FLOORS = {
    "concrete": {0.1: 1.1, 0.315: 2.5, 0.5: 4.2, 1.0: 17.3, 2.0: 3.3, 3.15: 1.4, 5.0: 2.8},
    "softwood": {0.2: 2.2, 0.5: 8.3, 1.0: 21.9, 2.0: 9.5, 3.15: 3.6, 5.0: 3.0, 8.0: 1.9},
}
"""Level [dB] of a floor relative to its foundation, mean over buildings, by the ratio of the
frequency to the floor's resonance."""
JUNCTIONS = {"cross": 8.7, "T": 5.7, "corner": -2.0}
"""Vibration reduction index [dB] of equal plates, through or round."""
CLASSES = {"soil": (0.003, 0.01, "II"), "sand": (0.01, 0.03, "I"), "gravel": (0.0003, 0.003, "III")}
"""Absorption [1/m] at 5 Hz of the class of a ground material."""
MOTOR = {102.0: 0.45, 156.0: 1.05, 241.0: 2.35}
"""Acceleration [g] of the motor on the skin, by frequency [Hz]."""

BUILDING = (1.0, 3.0)
"""Decibels per metre measured along walls and floors in place."""


@frozen
class Point:
    """One figure of a series: ``measured`` and ``modelled`` in the series' unit; ``judged``: not
    used for a fit; ``spread``: published scatter to either side, within which it agrees."""

    at: str
    measured: float
    modelled: float
    judged: bool = True
    spread: float = 0.0

    @property
    def error(self) -> float:
        return self.modelled - self.measured


@frozen
class Series:
    """A published series beside the model.

    Attributes:
        name, source, conditions: in words.
        kind: significance of the comparison: held out, fit, chosen, printed, definition, shown.
        unit: of the figures.
        limit: largest error of a judged figure without a spread, relative where ``unit`` is
            ``relative``; None without a criterion.
        remark: reason of a deviation, or interpretation.
        chosen: what in the model was chosen with it.
        uses: file and code line of a parameter that would change if it were fitted, for those
            held out.
    """

    name: str
    source: str
    conditions: str
    kind: str
    unit: str
    points: tuple[Point, ...]
    limit: float | None
    remark: str
    chosen: str
    uses: tuple[str, str] | None = None

    @property
    def worst(self) -> float:
        """Largest error of the judged figures."""
        errors = [
            abs(p.error / p.measured if self.unit == "relative" else p.error)
            for p in self.points
            if p.judged
        ]
        return max(errors, default=0.0)

    @property
    def verdict(self) -> str:
        if self.limit is None:
            return "shown"
        within = all(
            abs(p.error / p.measured if self.unit == "relative" else p.error)
            <= (p.spread or self.limit)
            for p in self.points
            if p.judged
        )
        return "agrees" if within else "missed"


def all_series() -> Iterator[Series]:
    """Every series, in the order of the page."""
    yield from ground()
    yield from into_buildings()
    yield from buildings()
    yield from materials()
    yield from body()


def fitted(
    function: Physical, distance: Sequence[float], level: Sequence[float], used: Sequence[bool]
) -> Physical:
    """``function`` with the absorption [1/m] fitted to the ``used`` levels [dB] by linear least
    squares."""
    d, y, chosen = np.array(distance), np.array(level), np.array(used)
    beyond = (d - d[0])[chosen]
    excess = (NEPER * np.log(function.spreading(d) / function.spreading(d[:1])) - y)[chosen]
    absorption = max(float((excess * beyond).sum() / (beyond**2).sum()) / NEPER, 0.0)
    return replace(function, loss_factor=0.0, absorption=absorption)


def levels(
    function: Physical | HapticTracing, distance: Sequence[float], k: float = 0.5
) -> FloatArray:
    """Levels [dB] over distances, relative to the first."""
    gains = function.gain(np.array(distance, dtype=np.float64), 0.0, k, 0.1)
    return np.asarray(NEPER * np.log(gains / gains[0]))


_OWN = "an absorption of this row alone; nothing of the library"
_DAMPING_LINE = "loss_factor=damping.loss_factor,"
_SPEED_LINE = "phase_speed=damping.speed,"
_LIMB_LINE = "resonance, speed = LIMBS.get(part, (function.resonance, function.phase_speed))"
_PAPER_LINE = "k * np.exp(-np.maximum(k, epsilon) * np.asarray(distance, dtype=np.float64))"
_BUILDING_LINE = "absorption=IN_A_BUILDING if in_a_building else 0.0,"
_MATCH_LINE = "gain = np.minimum(2 / (1 + load / driving), 1.0)"


def unfitted(name: str, frequency: float, distance: Sequence[float]) -> FloatArray:
    """Levels [dB] over distances on a ground material of the library, relative to the first."""
    function, d = physical(name, (100.0, 100.0, 10.0)), np.array(distance)
    spreading = NEPER * np.log(function.spreading(d) / function.spreading(d[:1]))
    return np.asarray(spreading - NEPER * function.material_damping(frequency) * (d - d[0]))


def ground() -> Iterator[Series]:
    """Attenuation with distance on the ground."""
    places = [7.62, 10.0, 15.0, 20.0, 30.5, 40.0, 50.0, 76.2]
    line = [30 * math.log10(places[0] / r) for r in places]
    used = [k % 2 == 1 for k in range(len(places))]
    body = fitted(Physical(thickness=1e6, extent=1e6), places, line, used)
    yield Series(
        "Construction machines",
        "FTA Report 0123 (2018), equation 7-2, as quoted in a county's file",
        "peak particle velocity, 7.6 to 76 m, no soil class",
        "fit",
        "dB",
        _points([f"{r:g} m" for r in places], line, levels(body, places), [not u for u in used]),
        CLOSE,
        f"spreading of a body wave; absorption {body.absorption:.4f} 1/m fitted to every second "
        "place",
        _OWN,
    )
    yield Series(
        "Construction machines by the library's soil",
        "as above",
        "30 Hz, surface waves, nothing fitted",
        "held out",
        "dB",
        _points([f"{r:g} m" for r in places], line, unfitted("soil", 30.0, places)),
        CLOSE,
        "a law for machines of no known frequency on no known soil",
        "nothing",
        ("core/scene/measured.py", _DAMPING_LINE),
    )
    yield from _machine_hall()
    yield from _ground_classes()
    loose = Physical(wave=Wave.SURFACE, loss_factor=0.02, phase_speed=200.0, material_k=0.5)
    left = [0.730, 0.208]
    model = [math.exp(-float(loose.damping(f, 0.0, 0.5)) * 100) for f in (10.0, 50.0)]
    yield Series(
        "Material damping of loose ground",
        "DIN 4150-1:2001, figure 2",
        "what 100 m leave at D = 0.01 and 200 m/s",
        "definition",
        "relative",
        _points(["10 Hz", "50 Hz"], left, model),
        2e-3,
        "the same formula: shows that its factors are right",
        "nothing; it has no parameter",
    )


def _machine_hall() -> Iterator[Series]:
    """One measured series, fitted in two ways, and by the paper's function."""
    hall, measured = HALL, HALL_LEVELS
    surface = fitted(
        Physical(wave=Wave.SURFACE, material_k=0.5), hall, measured, [True, False, False, True]
    )
    yield Series(
        "Outside a machine hall",
        "DIN 4150-1:2001, figure A.19, as read by the package phonometry",
        "vertical velocity, 13 to 73 m",
        "fit",
        "dB",
        _points(
            [f"{r:g} m" for r in hall], measured, levels(surface, hall), [False, True, True, False]
        ),
        CLOSE,
        f"spreading of a surface wave; absorption {surface.absorption:.4f} 1/m fitted to the "
        "first and last place",
        _OWN,
    )
    near = fitted(
        Physical(wave=Wave.SURFACE, material_k=0.5), hall, measured, [True, True, True, False]
    )
    yield Series(
        "The same, carried on from 43 m",
        "as above",
        "fitted to 13, 23 and 43 m, judged at 73 m",
        "fit",
        "dB",
        _points(
            [f"{r:g} m" for r in hall], measured, levels(near, hall), [False, False, False, True]
        ),
        CLOSE,
        "the series falls faster the further it goes; one absorption can't",
        _OWN,
    )
    for frequency in HALL_FREQUENCIES:
        yield Series(
            f"The same by the library's soil at {frequency:g} Hz",
            "as above",
            "nothing fitted; the frequency of the machines is not published",
            "held out",
            "dB",
            _points(
                [f"{r:g} m" for r in HALL],
                measured,
                unfitted("soil", frequency, HALL),
                [False, True, True, True],
            ),
            CLOSE,
            "soil of 200 m/s and a loss factor of 0.06, as for every soil",
            "nothing: its speed and loss factor are of the usual ranges, not of this figure",
            ("core/scene/measured.py", _SPEED_LINE),
        )
    soil = MATERIALS["soil"]
    yield Series(
        "The same by the paper's function",
        "as above",
        "the library's soil, nothing fitted",
        "held out",
        "dB",
        _points(
            [f"{r:g} m" for r in hall],
            measured,
            levels(HapticTracing(), hall, soil.k),
            [False, True, True, True],
        ),
        CLOSE,
        "K exp(-K d) was made for scenes of some metres, not for ground",
        "nothing: κ and ρ are chosen by design",
        ("core/scene/functions/modulation.py", _PAPER_LINE),
    )


def _ground_classes() -> Iterator[Series]:
    points = [
        Point(f"{name}, class {kind}, {f:g} Hz", min(max(alpha, low * f / 5), high * f / 5), alpha)
        for name, (low, high, kind) in CLASSES.items()
        for f in (5.0, 50.0)
        for alpha in (physical(name, (100.0, 100.0, 10.0)).material_damping(f),)
    ]
    yield Series(
        "Ground classes",
        "R. D. Woods, L. P. Jedele (1985), as recalled",
        "absorption by class; the nearest figure of the range stands under published",
        "shown",
        "1/m",
        tuple(points),
        None,
        "to hold it out, its document would have to be read; which class a material of the "
        "library is in is our choice",
        "nothing",
    )


SOIL = ("soil", (60.0, 30.0, 4.0))
FOUNDATION = ("concrete", (8.0, 8.0, 0.4))
"""A building's foundation, and the ground below it."""


def _through_contact(
    first: tuple[str, Vector], second: tuple[str, Vector], frequency: float, area: float = 0.0
) -> float:
    """Level [dB] of a body behind a contact of an ``area`` [m^2] with another, beside it; both by
    material and sizes [m]."""
    objects = [
        HapticObject(body, MATERIALS[name].kappa, MATERIALS[name].rho, physical(name, size))
        for body, (name, size) in (("1", first), ("2", second))
    ]
    table = ObjectTable.of(objects, 0.1)
    origin = (0.0, 0.0, 0.0)
    contacts = ContactSet.from_contacts(
        (Contact(("1", "2"), (origin, origin), Impedance(), area=area),), table.index()
    )
    _, passed = passed_by_bodies(table.bodies, contacts, ObjectFrames.unknown(2))
    band = sum(frequency >= edge for edge in BAND_EDGES[1:-1])
    return NEPER * math.log(passed[0, 0, band]) if len(passed) else 0.0


def into_buildings() -> Iterator[Series]:
    """From the ground into foundations, floors and over junctions of plates."""
    for place, measured in FOUNDATIONS.items():
        yield Series(
            f"Ground to foundation, {place}",
            "draft E DIN 45672-3:2023, annex A, as read by the package phonometry",
            "mean over buildings, scatter 5 dB at 4 Hz to 7.5 dB at 80 Hz",
            "held out",
            "dB",
            tuple(
                Point(
                    f"{f:g} Hz",
                    level,
                    _through_contact(SOIL, FOUNDATION, f, 64.0),
                    spread=foundation_spread(f),
                )
                for f, level in zip(FOUNDATION_HERTZ, measured, strict=True)
            ),
            CLOSE,
            "a slab of 8 m by 8 m by 0.4 m on soil, by their impedances",
            "nothing",
            ("core/graph/impedances.py", _MATCH_LINE),
        )
    for name, ratios in FLOORS.items():
        passed = _through_contact(FOUNDATION, (name, (8.0, 8.0, 0.2)), 30.0)
        yield Series(
            f"Foundation to floor, {'concrete' if name == 'concrete' else 'timber'}",
            "as above",
            "mean over buildings, by frequency over that of the floor's resonance",
            "held out",
            "dB",
            tuple(
                Point(f"{ratio:g}", level, passed, spread=6.9 if ratio == 1 else 0.0)
                for ratio, level in ratios.items()
            ),
            CLOSE,
            "floors resonate, the model has no gain above 1",
            "nothing",
            ("core/graph/impedances.py", _MATCH_LINE),
        )
    speed, thickness = DAMPING["concrete"].speed, 0.2
    plate = ("concrete", (4.0, 3.0, thickness))
    coincidence = 5 * math.log10(343.0**2 / (1.8 * speed * thickness) / 1000)
    yield Series(
        "Junctions of equal plates",
        "EN 12354-1, annex E, as read by the package phonometry",
        "vibration reduction index, concrete of 200 mm",
        "held out",
        "dB",
        tuple(
            Point(kind, index, coincidence - _through_contact(plate, plate, 500.0))
            for kind, index in JUNCTIONS.items()
        ),
        CLOSE,
        "two plates of one material touch: everything passes, where a junction shares power "
        "between plates and turns it round corners",
        "nothing",
        ("core/graph/impedances.py", _MATCH_LINE),
    )
    yield Series(
        "Plate of concrete built into a building",
        "EN 12354-1, formula C.3, as read by the package phonometry",
        "loss factor 0.01 + 460/(485 √f) of bending waves, 200 mm",
        "held out",
        "dB/m",
        tuple(
            Point(
                f"{f:g} Hz",
                NEPER
                * math.pi
                * f
                * (0.01 + 460 / (485 * math.sqrt(f)))
                / (2 * math.sqrt(1.8 * speed * thickness * f)),
                NEPER * physical("concrete", (4.0, 4.0, thickness), True).material_damping(f),
            )
            for f in (100.0, 500.0, 1000.0, 3000.0)
        ),
        1.0,
        "the model's 2 dB/m are from another paper, Acustica 2 (1952), which includes what "
        "reflections and coupling take",
        "nothing",
        ("core/scene/measured.py", _BUILDING_LINE),
    )


def foundation_spread(frequency: float) -> float:
    """Published scatter [dB] over buildings, from 5 at 4 Hz to 7.5 at 80 Hz."""
    return 5.0 + 2.5 * math.log(frequency / 4) / math.log(20)


def buildings() -> Iterator[Series]:
    """Along walls and floors in place."""
    low, high = BUILDING
    for name, thickness in (
        ("concrete", 0.2),
        ("brick", 0.24),
        ("plaster", 0.02),
        ("softwood", 0.02),
        ("plywood", 0.018),
    ):
        function = physical(name, (3.0, 3.0, thickness), in_a_building=True)
        own = MATERIALS[name]
        loss = [
            NEPER * float(function.damping(f, own.kappa, own.rho))
            for f in (150.0, 500.0, 1500.0, 3000.0)
        ]
        points = [
            Point(f"{f} Hz", min(max(x, low), high), x)
            for f, x in zip((150, 500, 1500, 3000), loss, strict=True)
        ]
        yield Series(
            f"{name.capitalize()} in a building, {thickness * 1000:g} mm",
            "Acustica 2 (1952), absorption of structure-borne sound in building materials "
            "(abstract)",
            "walls and floors in place, 1 to 3 dB/m at 150 to 3000 Hz",
            "chosen",
            "dB/m",
            tuple(points),
            0.005,
            "2 dB/m, the middle of what was measured, was chosen; bending losses come on top",
            "IN_A_BUILDING, 2 dB/m",
        )


def materials() -> Iterator[Series]:
    """Which of two materials loses more over three touching bars, wherever the published ranges
    don't overlap."""
    gains = {name: _through_bars(name) for name in DAMPING}
    for band in (0, 2, 3):
        frequency = BAND_CENTRES[band]
        right = total = 0
        for one, other in combinations(DAMPING, 2):
            ranges = [_loss_range(name, frequency) for name in (one, other)]
            if ranges[0][0] <= ranges[1][1] and ranges[1][0] <= ranges[0][1]:
                continue
            total += 1
            right += int((gains[one][band] > gains[other][band]) == (ranges[0][1] < ranges[1][0]))
        yield Series(
            f"Order of materials at {frequency:.0f} Hz",
            "ranges of loss factors and speeds, see Materials",
            "pairs whose ranges of loss per metre don't overlap, through three touching bars of "
            "1 m and 0.1 m thickness, contacts included",
            "chosen",
            "pairs",
            (Point("pairs in order", total, right),),
            0,
            "equal bodies touch as by default, without loss, flesh on flesh too. Out of order is "
            "what bends or spreads as on the ground, which the ranges leave out; some are "
            "estimates: the library says which",
            "the loss factors and speeds of materials.json, each within its range",
        )


def _through_bars(name: str) -> FloatArray:
    """Gains by band from end to end of three touching bars of a material."""
    function, own = physical(name, (1.0, 0.1, 0.1)), MATERIALS[name]
    names = ("1", "2", "3")
    places: list[Vector] = [(1.0, 0.0, 0.0), (2.0, 0.0, 0.0)]
    scene = HapticScene(
        tuple(HapticObject(bar, own.kappa, own.rho, function) for bar in names),
        tuple(
            Contact(pair, (place, place))
            for pair, place in zip(pairwise(names), places, strict=True)
        ),
        (Source("s", "1"),),
        (Listener("l", "3", (3.0, 0.0, 0.0), radius=0.0),),
    )
    result = Scene.of_values(scene).propagate()
    if result.band_gain is None:
        return np.full(len(BAND_CENTRES), float(result.gain[0, 0]))
    return np.asarray(result.band_gain[0, 0])


HAND_ARM = (("hand", 0.10), ("forearm", 0.25), ("upper_arm", 0.30))
LEG = (("foot", 0.10), ("lower_leg", 0.40), ("upper_leg", 0.40))
TRUNK = (("chest", 0.75),)
"""Parts on a path along the body from the excitation, and the distance in each [m]."""

HANDLE = (
    ("wrist", 1, 100.0, -10.0),
    ("wrist", 1, 250.0, -25.0),
    ("elbow", 2, 100.0, -14.0),
    ("shoulder", 3, 50.0, -20.0),
)
"""Joint, number of parts up to it, frequency [Hz], level [dB]; for elbow and shoulder only upper
limits are known."""

HEAD = (*HAND_ARM, ("head", 0.35))
HANDLE_TO_HEAD = tuple(
    (f, -20.0 - 15.0 * max(math.log2(f / 20), 0.0)) for f in (16.0, 31.5, 63.0, 125.0, 200.0)
)
"""Frequency [Hz] and published level [dB] at the head relative to a vibrating handle in the
hand."""

RESONANCES = (
    ("fingertip", "index_finger", 200, 200),
    ("wrist, as recalled", "hand", 20, 40),
    ("elbow", "forearm", 8, 8),
    ("head and trunk, as recalled", "chest", 4, 6),
    ("knee", "lower_leg", 20, 30),
    ("ankle", "foot", 16, 39),
    ("midfoot", "midfoot", 51, 84),
    ("toes", "toes", 99, 147),
)
"""Place, part of the model, lowest and highest published frequency [Hz]."""


def body_level(parts: Sequence[tuple[str, float]], frequency: float) -> float:
    """Level [dB] at the end of a path along parts of a body."""
    alpha = [
        physical("flesh", (0.1, 0.1, 0.3), part=part).material_damping(frequency)
        for part, _ in parts
    ]
    return -NEPER * sum(a * length for a, (_, length) in zip(alpha, parts, strict=True))


def skin_level(frequency: float, distance: float) -> float:
    """Level [dB] on skin at ``distance`` metres from a small actuator."""
    skin = physical("flesh", (0.3, 0.1, 0.003))
    return NEPER * (
        math.log(float(skin.spreading(np.array(distance))))
        - skin.material_damping(frequency) * distance
    )


def body() -> Iterator[Series]:
    """Along the skin from a small actuator, along limbs from a handle, from a seat to the head, and
    resonances."""
    points = [
        Point(f"{f:g} Hz, {d} cm", (max if f > 150 and d == 4 else min)(margin, 0.0), margin)
        for f, motor in MOTOR.items()
        for d in (4, 8, 12)
        for margin in (
            skin_level(f, d / 100) - float(threshold_level(f, FullScale(((f, 9.81 * motor),)))),
        )
    ]
    yield Series(
        "Skin, felt at 4 cm and gone beyond 8 cm",
        "Shah and others, Appl. Sci. 9 (2019) 4329, doi 10.3390/app9204329",
        "forearm, motor of 0.45 to 2.35 g: measurable at 4 cm above 150 Hz, far below the "
        "discrimination threshold beyond 8 cm. Under published stands 0 dB above the threshold of "
        "feeling, or the model's own figure on the right side of it",
        "held out",
        "dB",
        tuple(points),
        CLOSE,
        "waves along flesh of 7 m/s that spread from 5 mm (doi 10.1371/journal.pone.0031203); the "
        "threshold of a calibrated device; whether the motor's figures are amplitudes is assumed",
        "nothing: speed, loss and threshold are from others",
        ("core/scene/measured.py", _DAMPING_LINE),
    )
    yield from _along_limbs()
    whole = [
        (place, float(physical("flesh", (0.1, 0.1, 0.3), part=part).resonance), low, high)
        for place, part, low, high in RESONANCES
    ]
    yield Series(
        "Resonances of the body",
        "Lundström, J. Biomech. 17 (1984); Marchetti, Int. J. Ind. Ergon. 62 (2017) 82; Goggins, "
        "wbldb.lievers.net/10176750 and doi "
        "10.3233/OER-160236; doi 10.3390/app14209516 (abstracts)",
        "frequency of the largest response; the nearest figure of the range stands under published",
        "chosen",
        "Hz",
        tuple(Point(place, min(max(found, low), high), found) for place, found, low, high in whole),
        0.5,
        "up to it a part passes everything. A foot of one body has the resonance of its ankle; "
        "toes and midfoot have theirs as objects of "
        "these names",
        "the resonances of limbs.json",
    )


def _bone_floor() -> float:
    """Level [dB] behind flesh on bone, and flesh again, contacts by impedance."""
    thigh, femur = ("flesh", (0.15, 0.15, 0.4)), ("bone", (0.03, 0.03, 0.45))
    return _through_contact(thigh, femur, 100.0) + _through_contact(femur, thigh, 100.0)


def _along_limbs() -> Iterator[Series]:
    """From a handle along the arm to the head, and from a seat to the head."""
    yield Series(
        "Handle to wrist, elbow and shoulder",
        "Adewusi and others, J. Sound Vib. 329 (2010) 2953, doi 10.1016/j.jsv.2010.02.001, as "
        "recalled",
        "wrist at 100 and 250 Hz; elbow at 100 Hz and shoulder at 50 Hz, for which only a "
        "highest value is known",
        "fit",
        "dB",
        tuple(
            Point(
                f"{joint}, {f:g} Hz", known if count == 1 else min(known, level), level, count > 1
            )
            for joint, count, f, known in HANDLE
            for level in (body_level(HAND_ARM[:count], f),)
        ),
        0.005,
        "each part moves as a whole up to its resonance; the slope above suits the wrist, and "
        "for the arm was chosen so that the bounds "
        "hold. Of elbow and shoulder the model's own figure stands under published where it is "
        "below the known bound",
        "the speeds of hand, forearm and upper arm in limbs.json",
    )
    yield Series(
        "Handle to head",
        "Sakakibara and others, Scand. J. Work Environ. Health 12 (1986) 359 (abstract)",
        "four people standing, handle pulled up as if lifting 5 kg, arm stretched, 8 to 200 Hz: "
        "-20 dB at 12.5 to 16 Hz, 15 dB less "
        "per octave above 20 Hz",
        "held out",
        "dB",
        _points(
            [f"{f:g} Hz" for f, _ in HANDLE_TO_HEAD],
            [y for _, y in HANDLE_TO_HEAD],
            [body_level(HEAD, f) for f, _ in HANDLE_TO_HEAD],
        ),
        6.0,
        "a miss that is left. Measured heads lose 20 dB at best and then go by octaves; here arm "
        "and head pass everything up to their resonances and damp in proportion to frequency: too "
        "loud up to 80 Hz, too quiet from there. Bone would conduct more, but a floor of it by "
        f"impedance, flesh to bone and back, lies at {_bone_floor():.0f} dB, "
        f"{_bone_floor() + 69.83:.0f} dB above what was measured at 200 Hz: no better a guess, and "
        "it would change the levels of bodies in every file",
        "nothing; the parts were fitted to wrist, elbow, shoulder and seat, not to this",
        ("core/scene/measured.py", _LIMB_LINE),
    )
    seat = [(f, body_level(TRUNK, f)) for f in (15.0, 20.0)]
    yield Series(
        "Seat to head",
        "0.5 to 0.7 at 15 to 20 Hz, as recalled of many studies; data exist at doi "
        "10.3390/vibration6010012",
        "vertical, upright, 0.75 m; the nearest figure of the range stands under published",
        "fit",
        "dB",
        tuple(Point(f"{f:g} Hz", min(max(level, -6.02), -3.1), level, f < 20) for f, level in seat),
        1.0,
        "the speed of the trunk was fitted to 20 Hz; a peak of 1.5 to 2 at 4 to 6 Hz lies below "
        "the lowest band and above any gain",
        "the speed of head and trunk in limbs.json",
    )


def _loss_range(name: str, frequency: float) -> tuple[float, float]:
    """Least and largest published loss [dB/m] along a rod."""
    (low, high), (slow, fast) = DAMPING[name].loss_range, DAMPING[name].speed_range
    return NEPER * math.pi * frequency * low / fast, NEPER * math.pi * frequency * high / slow


def _points(
    places: Sequence[str],
    measured: Sequence[float],
    model: Sequence[float] | FloatArray,
    judged: Sequence[bool] = (),
) -> tuple[Point, ...]:
    flags = judged or [True] * len(places)
    return tuple(
        Point(a, float(b), float(c), d)
        for a, b, c, d in zip(places, measured, model, flags, strict=True)
    )
