"""Spreading and damping of vibration in bodies: lossy waves by their complex wave numbers,
monotony, bounds, bands."""

import cmath
import itertools
import math
from dataclasses import replace

import numpy as np
import pytest
from haptic_tracing.core.graph.haptic_graph import graph_of_scene
from haptic_tracing.core.propagation import propagate
from haptic_tracing.core.scene.bands import BAND_CENTRES
from haptic_tracing.core.scene.functions import Physical, Wave, function_from_dict
from haptic_tracing.core.scene.materials import MATERIALS
from haptic_tracing.core.scene.measured import DAMPING, physical
from haptic_tracing.core.scene.skeleton import part_in
from haptic_tracing.core.scene.values import HapticObject, HapticScene, Listener, Settings, Source
from hypothesis import given, settings
from hypothesis import strategies as st

K0 = (0.3, 0.8)  # kappa and rho of the material itself
MATERIAL_K = (1 - 0.3) * 0.8
OWN = {name: (material.kappa, material.rho) for name, material in MATERIALS.items()}


def gain(function, distance, kappa=K0[0], rho=K0[1]):
    return float(function.gain(np.array(distance), kappa, rho, 0.1))


@pytest.mark.parametrize("wave", [Wave.SURFACE, Wave.BOUNDED])
@pytest.mark.parametrize("frequency", [30.0, 100.0, 300.0])
def test_damping_is_that_of_a_lossy_wave(wave, frequency):
    """A modulus E (1 + i eta) gives the wave number k = (omega / c) / sqrt(1 + i eta); the
    amplitude falls by its imaginary part."""
    eta, speed = 0.02, 900.0
    k = 2 * math.pi * frequency / speed / cmath.sqrt(1 + 1j * eta)
    function = Physical(
        wave=wave, loss_factor=eta, phase_speed=speed, material_k=MATERIAL_K, thickness=1e3
    )
    assert float(function.damping(frequency, *K0)) == pytest.approx(-k.imag, rel=eta**2)


@pytest.mark.parametrize("frequency", [30.0, 100.0, 300.0])
def test_damping_of_bending_waves(frequency):
    """k^4 = omega^2 m'' / (B (1 + i eta)), B = E h^3 / (12 (1 - nu^2)), so that the amplitude falls
    by eta / 4 of k."""
    eta, speed, thickness, nu = 0.02, 3400.0, 0.2, 0.3
    density = 2300.0
    stiffness = density * speed**2 * thickness**3 / 12  # with the plate's own longitudinal speed
    k = (
        complex((2 * math.pi * frequency) ** 2 * density * thickness) / (stiffness * (1 + 1j * eta))
    ) ** 0.25
    function = Physical(
        loss_factor=eta,
        phase_speed=speed,
        thickness=thickness,
        material_k=MATERIAL_K,
    )
    assert nu == 0.3
    # 1.8 is 2 pi / sqrt(12) rounded.
    assert float(function.damping(frequency, *K0)) == pytest.approx(-k.imag, rel=0.01)


@pytest.mark.parametrize(
    ("body", "per_doubling"),
    [
        ({"extent": 1e-3, "thickness": 1e-3}, 0.0),
        ({"thickness": 1e-3}, 3.01),
        ({"wave": Wave.SURFACE}, 3.01),
        ({"thickness": 100.0}, 6.02),
        ({"wave": Wave.LIMB}, 0.0),
    ],
    ids=["rod", "plate", "half-space", "solid", "limb"],
)
def test_spreading_in_decibels_per_doubling_of_distance(body, per_doubling):
    function = Physical(loss_factor=0.0, material_k=MATERIAL_K, reference_distance=0.001, **body)
    assert 20 * math.log10(gain(function, 10.0) / gain(function, 20.0)) == pytest.approx(
        per_doubling, abs=0.01
    )


SIZES = st.floats(1e-4, 50)


@settings(max_examples=300, deadline=None)
@given(SIZES, SIZES, st.floats(0.01, 3), st.lists(st.floats(0, 100), min_size=3, max_size=3))
def test_a_wave_spreads_until_it_fills_the_body(one, other, radius, distances):
    """By the formula of the documentation; its cost is 0 at 0, non-decreasing and concave, hence a
    metric."""
    c, b = sorted((one, other))
    function = Physical(
        wave=Wave.BOUNDED,
        loss_factor=0.0,
        material_k=MATERIAL_K,
        thickness=c,
        extent=b,
        reference_distance=radius,
    )
    through, width = max(c - radius, 0.0), max(radius, c)
    over = max(b - width, 0.0)

    def cost(d: float) -> float:
        return -math.log(gain(function, d))

    for d in distances:
        volume = min(d, through)
        expected = (1 + volume / radius) ** -1 * (
            1 + (min(d, through + over) - volume) / width
        ) ** -0.5
        assert gain(function, d) == pytest.approx(expected, rel=1e-12)
    near, middle, far = sorted(distances)
    assert cost(0.0) == 0.0
    assert cost(near) <= cost(middle) + 1e-12 <= cost(far) + 2e-12
    if far > near:
        part = (middle - near) / (far - near)
        assert cost(middle) >= (1 - part) * cost(near) + part * cost(far) - 1e-9


@settings(max_examples=300, deadline=None)
@given(
    st.sampled_from(sorted(set(DAMPING) - {"flesh"})),
    st.tuples(SIZES, SIZES, SIZES),
    st.integers(0, 2),
    st.floats(0.1, 30),
)
def test_a_hundredth_of_a_size_moves_no_level_by_a_tenth_of_a_decibel(name, size, which, distance):
    """But for what lies 20 dB and more down by damping alone, which is proportional to the root of
    a thickness."""
    changed = tuple(
        length * 1.01 if number == which else length for number, length in enumerate(size)
    )
    levels = [
        20 * math.log10(max(gain(physical(name, one), distance, *OWN[name]), 1e-300))
        for one in (size, changed)
    ]
    damped = 8.686 * physical(name, size).material_damping(BAND_CENTRES[0]) * distance
    assert abs(levels[0] - levels[1]) < max(0.1, 0.0051 * damped)


def test_spreading_ends_at_the_extent_of_the_body():
    function = Physical(loss_factor=0.0, material_k=MATERIAL_K, extent=2.0)
    assert gain(function, 1.0) > gain(function, 2.0) == gain(function, 50.0)


PARAMETERS = st.builds(
    Physical,
    wave=st.sampled_from(Wave),
    loss_factor=st.floats(0, 1),
    phase_speed=st.floats(1, 6000),
    thickness=st.floats(1e-3, 2),
    absorption=st.floats(0, 5),
    material_k=st.floats(0.01, 0.99),
    reference_distance=st.floats(0.01, 10),
    extent=st.just(0.0) | st.floats(0.01, 100),
)


@settings(max_examples=300, deadline=None)
@given(
    PARAMETERS,
    st.floats(0, 1),
    st.floats(0, 1),
    st.floats(0, 1),
    st.floats(0, 1),
    st.floats(0, 1e4),
    st.floats(0, 1e4),
)
def test_never_above_one_and_monotonic(
    function, kappa, other_kappa, rho, other_rho, distance, other_distance
):
    (kappa, worse), (weaker, rho) = sorted((kappa, other_kappa)), sorted((rho, other_rho))
    near, far = sorted((distance, other_distance))
    value = gain(function, near, kappa, rho)
    assert 0 <= value <= 1
    assert gain(function, far, kappa, rho) <= value
    assert gain(function, near, worse, rho) <= value * (1 + 1e-12)
    assert gain(function, near, kappa, weaker) <= value * (1 + 1e-12)
    decays = function.band_decays(kappa, rho)
    assert len(decays) in (0, len(BAND_CENTRES))
    for decay in decays:
        assert decay >= 0
    assert function_from_dict(function.to_dict()) == function


def test_the_materials_own_coefficients_change_nothing():
    lossy = Physical(
        loss_factor=0.1, phase_speed=200.0, material_k=MATERIAL_K, thickness=100.0, extent=0.1
    )
    lossy = replace(lossy, reference_distance=1e9)
    alpha = math.pi * BAND_CENTRES[0] * 0.1 / 200
    assert gain(lossy, 3.0) == pytest.approx(math.exp(-3 * alpha), rel=1e-12)
    assert gain(lossy, 3.0, 0.0, 1.0) == 1.0


def test_a_dial_beyond_the_materials_own_value_is_the_papers_factor():
    """(1 - kappa) rho over that of the material, once per body; the damping is scaled by the
    logarithms."""
    lossy = Physical(loss_factor=0.1, phase_speed=200.0, material_k=MATERIAL_K, extent=0.1)
    alpha = lossy.material_damping(BAND_CENTRES[0])
    for kappa, rho in ((0.5, 0.8), (0.3, 0.2), (0.95, 0.1)):
        k = (1 - kappa) * rho
        for d in (0.0, 3.0):
            wanted = k / MATERIAL_K * math.exp(-d * alpha * math.log(k) / math.log(MATERIAL_K))
            assert gain(lossy, d, kappa, rho) == pytest.approx(wanted, rel=1e-12)
    for d in (0.0, 3.0):
        assert gain(lossy, d, 0.5, 0.0) == gain(lossy, d, 1.0, 0.8) == 0.0


def test_each_tenth_of_a_dial_is_felt_on_a_desk():
    """At 1 m on a desk of hardwood, from the material's own values up: at least 1 dB for each
    tenth, the smallest difference of amplitudes that people notice (Israr, Tan and Reed, 2006: 1.65
    dB) for most of them, and silence at the end without a jump."""
    own, desk = MATERIALS["hardwood"], physical("hardwood", (1.6, 0.8, 0.03))
    level = {
        k: 20 * math.log10(gain(desk, 1.0, k / 100, own.rho))
        for k in range(round(100 * own.kappa), 100)
    }
    assert all(level[k] - level[k + 10] >= 1.0 for k in range(round(100 * own.kappa), 90))
    assert level[25] - level[92] == pytest.approx(20, abs=1.0)
    assert gain(desk, 1.0, 1.0 - 1e-9, own.rho) < 1e-8
    assert gain(desk, 1.0, 0.0, 1.0) >= gain(desk, 1.0, own.kappa, own.rho)
    by_rho = [gain(desk, 1.0, own.kappa, own.rho - step / 10) for step in range(7)]
    assert all(20 * math.log10(a / b) >= 1.0 for a, b in itertools.pairwise(by_rho))


@settings(max_examples=100, deadline=None)
@given(st.sampled_from(sorted(DAMPING)), st.floats(0, 1), st.floats(0, 10))
def test_dials_move_without_jumps(name, kappa, distance):
    """A step of a millionth of the dial, down to where a thousandth of the material's own
    coefficient is left, moves the gain by less than a thousandth, in each band."""
    function, material = physical(name, (2.0, 1.0, 0.1)), MATERIALS[name]
    kappa = min(kappa, 1 - 1e-3)

    def levels(kappa):
        factor, decay = function.log_linear(kappa, material.rho, 0.1)
        decays = np.array(function.band_decays(kappa, material.rho) or 0.0)
        return np.log(factor) - (decay + decays) * distance

    damping = max(map(function.material_damping, BAND_CENTRES)) * distance
    slope = (1 + damping / -math.log(function.material_k)) / (1 - kappa - 1e-6)
    step = levels(kappa) - levels(kappa + 1e-6)
    assert (step >= -1e-9 * (1 + damping)).all()
    assert (step <= 1.01e-6 * slope + 1e-9 * (1 + damping)).all()


def test_bands_of_a_body_follow_the_formula():
    """One object, source and listener 4 m apart."""
    function = Physical(
        wave=Wave.SURFACE,
        loss_factor=0.06,
        phase_speed=200.0,
        material_k=MATERIAL_K,
        reference_distance=1.0,
    )
    scene = HapticScene(
        objects=(HapticObject("ground", *K0, propagation=function),),
        sources=(Source("drill", "ground", (0, 0, 0)),),
        listeners=(Listener("foot", "ground", (4, 0, 0), radius=0.0),),
        settings=Settings(threshold=0.0),
    )
    result = propagate(graph_of_scene(scene), scene.settings)
    assert result.gain[0, 0] == pytest.approx(
        5**-0.5 * math.exp(-math.pi * BAND_CENTRES[0] * 0.06 / 200 * 4), rel=1e-12
    )
    for band, centre in enumerate(BAND_CENTRES):
        wanted = 5**-0.5 * math.exp(-math.pi * centre * 0.06 / 200 * 4)
        assert result.band_gain[0, 0, band] == pytest.approx(wanted, rel=1e-12)


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("wave", "ether"),
        ("loss_factor", -1.0),
        ("phase_speed", 0.0),
        ("thickness", math.nan),
        ("material_k", 1.0),
        ("extent", -1.0),
    ],
)
def test_bad_parameters_are_named(key, value):
    with pytest.raises(ValueError, match=key):
        Physical(**{key: value})


@pytest.mark.parametrize(
    ("part", "published"),
    [
        ("hand", (20, 40)),
        ("forearm", (8, 8)),
        ("foot", (16, 39)),
        ("lower_leg", (20, 30)),
        ("head", (4, 6)),
        ("midfoot", (51, 84)),
        ("toes", (99, 147)),
    ],
)
def test_a_part_of_a_body_moves_as_a_whole_up_to_its_published_resonance(part, published):
    function = physical("flesh", (0.1, 0.1, 0.3), part=part)
    assert function.material_damping(published[0]) == 0.0
    assert function.material_damping(published[1] + 1) > 0.0
    above = [function.material_damping(function.resonance + more) for more in (10.0, 20.0)]
    assert above[1] == pytest.approx(2 * above[0])  # a constant loss factor damps by the cycle


def test_a_body_in_one_mesh_loses_from_sole_to_crown_what_its_parts_lose():
    """Heights of ankle, knee, hip and crown by Drillis and Contini (1966), in parts of the body's,
    as printed by Winter."""
    joints = (0.0, 0.039, 0.285, 0.53, 1.0)
    parts = [
        physical("flesh", (0.1, 0.1, 0.3), part=part)
        for part in ("foot", "lower_leg", "upper_leg", "hips")
    ]
    whole = physical("flesh", (0.5, 0.3, 1.75))
    for frequency in (80.0, 150.0, 250.0, 500.0):
        along = sum(
            part.material_damping(frequency) * (high - low)
            for part, low, high in zip(parts, joints, joints[1:], strict=False)
        )
        assert whole.material_damping(frequency) == pytest.approx(along, rel=0.02)


def test_thin_flesh_is_skin():
    """What Shah and others (2019) measured: there at 4 cm, far weaker beyond 8 cm, as the high
    frequencies lose more."""
    skin = physical("flesh", (0.3, 0.1, 0.003))
    level = [
        20 * math.log10(float(skin.spreading(np.array(d))))
        - 8.686 * skin.material_damping(160.0) * d
        for d in (0.04, 0.08, 0.12)
    ]
    assert level[0] > -20 > -25 > level[1] > level[2] + 8
    assert skin.material_damping(240.0) > 1.4 * skin.material_damping(160.0)


@pytest.mark.parametrize(
    ("name", "part"),
    [
        ("Avatar Upper Arm.L", "upper_arm"),
        ("LeftUpLeg", "upper_leg"),
        ("Avatar Shin.R", "lower_leg"),
        ("hand.R", "hand"),
        ("Foot Toes.L", "toes"),
        ("Mid Foot.R", "midfoot"),
        ("Hammer", ""),
        ("足 12", ""),
    ],
)
def test_parts_by_names(name, part):
    assert part_in(name) == part
