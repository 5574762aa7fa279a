"""Comparison of the model with published measurements and printed solutions.

Levels are amplitudes in decibels relative to the first place of a series. Places used for a fit are
not judged. The page marks sources that could not be read in full.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from ..core.arrays import FloatArray
from ..core.graph.haptic_graph import graph_of_scene
from ..core.propagation import propagate
from ..core.propagation.conjugate_gradients import PowerBalance, solve
from ..core.scene.functions import Constant, HapticTracing, Physical, Wave
from ..core.scene.materials import MATERIALS
from ..core.scene.measured import DAMPING, physical
from ..core.scene.values import (
    Contact,
    HapticObject,
    HapticScene,
    Listener,
    Settings,
    Source,
    Strategy,
)

NEPER = 20 / math.log(10)
CLOSE = 3.0
"""Largest accepted error of a ground model [dB]."""

BUILDING = (1.0, 3.0)
"""Decibels per metre measured along walls and floors in place."""


@dataclass(frozen=True, slots=True)
class Point:
    """One figure of a series: ``measured`` and ``modelled`` in the series' unit; ``judged``: not
    used for a fit."""

    at: str
    measured: float
    modelled: float
    judged: bool = True

    @property
    def error(self) -> float:
        return self.modelled - self.measured


@dataclass(frozen=True, slots=True)
class Series:
    """A published series beside the model.

    Attributes:
        name, source, conditions: in words.
        kind: significance of the comparison: fit, validation, printed, definition, chosen.
        unit: of the figures.
        limit: largest error of a judged figure, relative where ``unit`` is ``relative``; None
            without a criterion.
    remark: reason of a deviation, or interpretation.
    """

    name: str
    source: str
    conditions: str
    kind: str
    unit: str
    points: tuple[Point, ...]
    limit: float | None
    remark: str = ""

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
        return "agrees" if self.worst <= self.limit else "missed"


def all_series() -> Iterator[Series]:
    """Every series, in the order of the page."""
    yield from ground()
    yield from buildings()
    yield from energy()
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
    return Physical(
        wave=function.wave,
        loss_factor=0.0,
        absorption=absorption,
        phase_speed=function.phase_speed,
        material_k=function.material_k,
    )


def levels(
    function: Physical | HapticTracing, distance: Sequence[float], k: float = 0.5
) -> FloatArray:
    """Levels [dB] over distances, relative to the first."""
    gains = function.gain(np.array(distance, dtype=np.float64), 0.0, k, 0.1)
    return np.asarray(NEPER * np.log(gains / gains[0]))


def ground() -> Iterator[Series]:
    """Attenuation with distance on the ground."""
    places = [7.62, 10.0, 15.0, 20.0, 30.5, 40.0, 50.0, 76.2]
    line = [30 * math.log10(places[0] / r) for r in places]
    used = [k % 2 == 1 for k in range(len(places))]
    body = fitted(Physical(wave=Wave.SOLID, material_k=0.5), places, line, used)
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
    )
    yield from _machine_hall()
    loose = Physical(wave=Wave.ROD, loss_factor=0.02, phase_speed=200.0, material_k=0.5)
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
    )


def _machine_hall() -> Iterator[Series]:
    """One measured series, fitted in two ways, and by the paper's function."""
    hall, measured = [13.0, 23.0, 43.0, 73.0], [0.0, -4.2, -13.8, -29.3]
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
    )
    soil = MATERIALS["soil"]
    yield Series(
        "The same by the paper's function",
        "as above",
        "the library's soil, nothing fitted",
        "validation",
        "dB",
        _points(
            [f"{r:g} m" for r in hall],
            measured,
            levels(HapticTracing(), hall, soil.k),
            [False, True, True, True],
        ),
        CLOSE,
        "K exp(-K d) was made for scenes of some metres, not for ground",
    )


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
        )


@dataclass(frozen=True, slots=True)
class Plates:
    """Equal steel plates of 1 m² and 3 mm, joined along 1 m at right angles; 1 W goes into the
    first. ``printed``: their energies [J]."""

    name: str
    transmission: float
    count: int
    printed: dict[int, tuple[float, float]]


PLATES = (
    Plates(
        "Two plates, L joint",
        1 / 3,
        2,
        {
            250: (0.041407, 0.022255),
            500: (0.021936, 0.0098947),
            1000: (0.011638, 0.0042771),
            2000: (0.0061630, 0.0017947),
            4000: (0.0032478, 0.00073113),
        },
    ),
    Plates(
        "Four plates, X joint",
        1 / 12,
        4,
        {250: (0.037999, 0.0085543), 500: (0.021063, 0.0035895), 1000: (0.011529, 0.0014623)},
    ),
    Plates(
        "Three plates, T joint",
        4 / 27,
        3,
        {250: (0.037868, 0.012897), 500: (0.020737, 0.0055472), 1000: (0.011284, 0.0023159)},
    ),
)
MODULUS, POISSON, DENSITY, THICKNESS = 210e9, 0.3, 7800.0, 3e-3
INTERNAL = 0.01
FULL_MODEL = {250: 0.022155, 500: 0.0098010, 1000: 0.0042206, 2000: 0.0017347, 4000: 0.00068677}
"""Energy of the second plate with in-plane waves as well, by the package pyva-toolbox 1.3.0."""


def coupling_loss(transmission: float, frequency: float) -> float:
    """Coupling loss factor of a joint of 1 m on a plate of 1 m²: c_g τ L / (2 π² f S)."""
    stiffness = MODULUS * THICKNESS**3 / (12 * (1 - POISSON**2))
    bending = math.sqrt(math.sqrt(stiffness / (DENSITY * THICKNESS))) * math.sqrt(
        2 * math.pi * frequency
    )
    return 2 * bending * transmission / (2 * math.pi**2 * frequency)


def plate_energies(plates: Plates, frequency: float) -> FloatArray:
    """Energies [J] of equal plates, by the solver of the energy balance."""
    omega, n = 2 * math.pi * frequency, plates.count
    row, column = np.array([(a, b) for a in range(n) for b in range(n) if a != b]).T
    coupling = np.full((1, len(row)), omega * coupling_loss(plates.transmission, frequency))
    balance = PowerBalance(
        np.full((1, n), omega * INTERNAL), np.zeros((1, n)), row, column, coupling
    )
    power = np.zeros((1, 1, n))
    power[0, 0, 0] = 1.0
    return np.asarray(solve(balance, power, lambda energy: 1e-13 * energy.max(axis=2)).energy[0, 0])


def energy() -> Iterator[Series]:
    """Statistical energy analysis."""
    for plates in PLATES:
        points = []
        for frequency, printed in plates.printed.items():
            found = plate_energies(plates, frequency)
            points += [
                Point(f"{frequency} Hz, plate {k + 1}", printed[k], float(found[k])) for k in (0, 1)
            ]
        yield Series(
            plates.name,
            "closed form; coupling by C. Hopkins, Sound Insulation (2007), bending waves only",
            "steel, 3 mm, 1 m² each, loss factor 0.01, 1 W into the first",
            "printed",
            "relative",
            tuple(points),
            5e-5,
            "the solver given the same subsystems and coupling factors; to the last printed digit",
        )
    ell = PLATES[0]
    points = [
        Point(f"{f} Hz", value, float(plate_energies(ell, f)[1])) for f, value in FULL_MODEL.items()
    ]
    yield Series(
        "L joint, in-plane waves as well",
        "pyva-toolbox 1.3.0, run on the same plates",
        "energy of the second plate",
        "validation",
        "relative",
        tuple(points),
        None,
        "bending alone: what goes over into in-plane waves is missing",
    )
    shown = [
        Point(f"{f} Hz", 10 * math.log10(e2 / e1), _own_ratio())
        for f, (e1, e2) in ell.printed.items()
    ]
    yield Series(
        "L joint by haptic coefficients",
        "closed form as above",
        "second plate against first, two touching lossless objects",
        "validation",
        "dB",
        tuple(shown),
        None,
        "a contact passes on what its function says, the same at all frequencies",
    )
    left, right = (4.4e-3, 0.08722), (2.4e-3, 0.013302)
    balance = PowerBalance(
        np.array([[left[0] * 0.557, right[0] * 0.606]]),
        np.zeros((1, 2)),
        np.array([0, 1]),
        np.array([1, 0]),
        np.full((1, 2), 4.26e-4 * 0.557),
    )
    power = 2 * math.pi * 500 * (left[0] * left[1] + right[0] * right[1])
    driven = np.zeros((1, 1, 2))
    driven[0, 0, 0] = power / (2 * math.pi * 500)
    modal = solve(balance, driven, lambda energy: 1e-13 * energy.max(axis=2)).energy[0, 0]
    yield Series(
        "Plate and cylinder",
        "M. P. Norton, D. G. Karczub, Fundamentals of Noise and Vibration Analysis (2003), "
        "problem 6.10",
        "500 Hz; energies and power",
        "printed",
        "relative",
        (
            Point("power [W]", 1.31, power),
            Point("plate [J]", left[1], float(modal[0]) * 0.557),
            Point("cylinder [J]", right[1], float(modal[1]) * 0.606),
        ),
        5e-3,
        "printed with three digits",
    )


def _own_ratio() -> float:
    """Level [dB] of the second of two touching lossless objects, by the energy balance."""
    objects = tuple(HapticObject(name, 0.0, 1.0, Constant(gain_value=1.0)) for name in ("a", "b"))
    scene = HapticScene(
        objects,
        (Contact(("a", "b"), ((0, 0, 0), (0, 0, 0))),),
        (Source("s", "a"),),
        (Listener("1", "a"), Listener("2", "b")),
    )
    gain = propagate(graph_of_scene(scene), Settings(strategy=Strategy.ENERGY_BALANCE)).gain[0]
    return 20 * math.log10(float(gain[1]) / float(gain[0]))


def materials() -> Iterator[Series]:
    """Which of two materials loses more over a metre, wherever the published ranges don't
    overlap."""
    for frequency in (30.0, 100.0, 300.0):
        right = total = 0
        for one, other in combinations(DAMPING, 2):
            ranges = [_loss_range(name, frequency) for name in (one, other)]
            if ranges[0][0] <= ranges[1][1] and ranges[1][0] <= ranges[0][1]:
                continue
            losses = [_loss(name, frequency) for name in (one, other)]
            total += 1
            right += (losses[0] < losses[1]) == (ranges[0][1] < ranges[1][0])
        yield Series(
            f"Order of materials at {frequency:g} Hz",
            "ranges of loss factors and speeds, see Materials",
            "pairs whose ranges of loss per metre don't overlap, along the same body",
            "validation",
            "pairs",
            (Point("pairs in order", total, right),),
            0,
            "some ranges are estimates: the library says which",
        )


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
    near, far = [(f, 4) for f in (160, 240)], [(f, d) for f in (160, 240) for d in (8, 12)]
    yield Series(
        "Skin, felt at 4 cm and gone beyond 8 cm",
        "Shah and others, Appl. Sci. 9 (2019) 4329, doi 10.3390/app9204329",
        "forearm, motor of 100 to 240 Hz: measurable at 4 cm above 150 Hz, far below the "
        "discrimination threshold beyond 8 cm; no levels",
        "chosen",
        "dB",
        tuple(
            Point(f"{f} Hz, {d} cm", best(level, -23.0), level)
            for places, best in ((near, max), (far, min))
            for f, d in places
            for level in (skin_level(f, d / 100),)
        ),
        0.005,
        "a wave along flesh of 7 m/s that spreads from 5 mm; a source 23 dB above the threshold "
        "was chosen as the border between felt and "
        "gone, for no levels are published: where the model is on the right side of it, its own "
        "figure stands under published",
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
    )


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
    )
    yield Series(
        "Handle to head",
        "Sakakibara and others, Scand. J. Work Environ. Health 12 (1986) 359 (abstract)",
        "four people standing, handle pulled up as if lifting 5 kg, arm stretched, 8 to 200 Hz: "
        "-20 dB at 12.5 to 16 Hz, 15 dB less "
        "per octave above 20 Hz",
        "validation",
        "dB",
        _points(
            [f"{f:g} Hz" for f, _ in HANDLE_TO_HEAD],
            [y for _, y in HANDLE_TO_HEAD],
            [body_level(HEAD, f) for f, _ in HANDLE_TO_HEAD],
        ),
        6.0,
        "nothing was fitted. Measured heads lose 20 dB at best and then go by octaves; here arm "
        "and head pass everything up to their "
        "resonances and damp in proportion to frequency: too loud up to 80 Hz, too quiet from "
        "there",
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
    )


def _loss(name: str, frequency: float) -> float:
    """Loss [dB/m] along a rod."""
    material = MATERIALS[name]
    own = Physical(
        wave=Wave.ROD,
        loss_factor=DAMPING[name].loss_factor,
        phase_speed=DAMPING[name].speed,
        material_k=material.k,
    )
    return NEPER * float(own.damping(frequency, material.kappa, material.rho))


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
