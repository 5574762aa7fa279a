"""Warmth against the differential equation of the plates, solved by finite differences, and against
closed forms."""

import math
from dataclasses import replace
from pathlib import Path

import haptic_tracing
import numpy as np
import pytest
from haptic_tracing.core.contacts.contact_set import ContactSet
from haptic_tracing.core.modalities import MODALITIES, THERMAL
from haptic_tracing.core.modalities.propagation import Emitter, ModalityScene
from haptic_tracing.core.modalities.thermal import JOINT
from haptic_tracing.core.scene.functions import FUNCTIONS, Conduction
from haptic_tracing.core.scene.values import Contact, Listener, Settings
from scipy.integrate import solve_bvp
from scipy.sparse import diags
from scipy.sparse.linalg import spsolve


@pytest.mark.parametrize(("k", "t", "h"), [(2.8, 0.3, 10.0), (50.0, 0.01, 25.0), (0.13, 0.05, 5.0)])
def test_conduction_solves_the_fin_equation(k, t, h):
    m = math.sqrt(2 * h / (k * t))
    length = 12 / m
    solution = solve_bvp(
        lambda x, y: np.vstack([y[1], 2 * h / (k * t) * y[0]]),
        lambda start, end: np.array([start[0] - 1, end[1] + m * end[0]]),
        np.linspace(0, length, 200),
        np.zeros((2, 200)),
        tol=1e-8,
    )
    x = np.linspace(0, 4 / m, 20)
    gains = Conduction(conductivity=k, thickness=t, exchange=h).gain(x, 0, 1, 0.1)
    assert gains == pytest.approx(solution.sol(x)[0], abs=1e-6)


def _plates(k, t, h, first, second, step):
    """Temperatures of two plates that meet at a joint, the first kept at 1 at its start: finite
    differences."""
    n1, n2 = round(first / step), round(second / step)
    n = n1 + n2
    main = np.full(n, -2 * k * t / step**2 - 2 * h)
    side = np.full(n - 1, k * t / step**2)
    # Half a cell of plate on either side of the joint.
    joint = 1 / (1 / JOINT + step / k) * t / step
    side[n1 - 1] = joint
    main[n1 - 1] += k * t / step**2 - joint
    main[n1] += k * t / step**2 - joint
    main[-1] += k * t / step**2
    right = np.zeros(n)
    main[0] -= k * t / step**2  # the end kept warm is half a cell away
    right[0] = -2 * k * t / step**2
    return spsolve(diags([side, main, side], [-1, 0, 1], format="csc"), right), n1


def test_a_joint_passes_on_what_the_finite_differences_say():
    k, t, h = 2.8, 0.2, 10.0
    m = math.sqrt(2 * h / (k * t))
    temperature, n1 = _plates(k, t, h, 0.5, 12 / m, 1e-4)
    gain = THERMAL.transmission({"conductivity": k, "thickness": t, "exchange": h})
    assert temperature[n1] / temperature[n1 - 1] == pytest.approx(gain, rel=2e-3)


def _bench(values, temperature=60.0):
    """A fire on a stone hearth, on which a stone bench lies; a listener 0.8 m along the bench."""
    contact = Contact(("bench", "hearth"), ((0.4, 0, 0), (0.4, 0, 0)), area=0.1)
    contacts = ContactSet.from_contacts((contact,), {"bench": 0, "hearth": 1})
    emitters = (Emitter("fire", "hearth", (0, 0, 0), temperature),)
    fire = ModalityScene(THERMAL, values, {}, emitters)
    return fire.felt(
        ("bench", "hearth"), contacts, [Listener("seat", "bench", (1.2, 0, 0))], Settings()
    )


def test_a_fire_is_felt_through_a_stone_bench():
    stone = {"conductivity": 2.8, "thickness": 0.3, "exchange": 10.0}
    felt = _bench({"bench": stone, "hearth": stone})
    m = math.sqrt(20 / (2.8 * 0.3))
    expected = 60 * math.exp(-m * 1.2) * JOINT / (JOINT + 2.8 * m)
    assert felt.values[0] == pytest.approx(expected, rel=1e-12)
    assert felt.paths[0, 0] == ("hearth", "bench")
    wood = {"conductivity": 0.13, "thickness": 0.3, "exchange": 10.0}
    assert _bench({"bench": wood, "hearth": stone}).values[0] < 0.05 * felt.values[0]


def test_cold_sources_and_many_sources_add_up():
    stone = {"conductivity": 2.8}
    values = {"bench": stone, "hearth": stone}
    assert _bench(values, -20.0).values[0] == pytest.approx(-_bench(values, 20.0).values[0])


def test_an_author_may_choose_another_function_of_the_modality():
    contacts = ContactSet.empty()
    emitters, listeners = (
        (Emitter("fire", "a", (0, 0, 0), 10.0),),
        [Listener("skin", "a", (2, 0, 0))],
    )
    fire = ModalityScene(THERMAL, {}, {"a": {"function": "linear", "range": 4.0}}, emitters)
    felt = fire.felt(("a",), contacts, listeners, Settings())
    assert felt.values[0] == pytest.approx(5.0)
    with pytest.raises(ValueError, match="function: unknown 'haptic_tracing'"):
        replace(fire, forms={"a": {"function": "haptic_tracing"}}).felt(
            ("a",), contacts, listeners, Settings()
        )


def test_nothing_is_felt_where_nobody_emits():
    felt = ModalityScene(THERMAL).felt(
        ("a",), ContactSet.empty(), [Listener("skin", "a")], Settings()
    )
    assert felt.values.tolist() == [0.0]


def test_sensations_rise_with_the_value():
    assert [THERMAL.sensation(value) for value in (0.0, 1.0, 5.0, 13.0, 19.0, 30.0)] == [
        "", "hardly warmer", "lukewarm", "warm", "hot", "burns",
    ]  # fmt: skip


@pytest.mark.parametrize("modality", MODALITIES.values(), ids=MODALITIES)
def test_modalities_are_consistent_data(modality):
    assert modality.default_function in modality.functions
    assert set(modality.functions) <= {*FUNCTIONS, "conduction"}
    for name, quantity in modality.quantities.items():
        assert quantity.low <= modality.defaults()[name] <= quantity.high
    assert list(modality.sensations) == sorted(modality.sensations)
    assert 0 <= modality.transmission(modality.defaults()) <= 1


def test_a_third_modality_is_one_value():
    """The example of the documentation, as it stands there."""
    text = (Path(haptic_tracing.__file__).parent / "docs" / "functions.md").read_text(
        encoding="utf-8"
    )
    source = text.split("```python\n")[1].split("```")[0]
    names = {
        "__name__": "haptic_tracing.core.modalities",
        "__package__": "haptic_tracing.core.modalities",
    }
    exec(compile(source, "functions.md", "exec"), names)
    wind = names["WIND"]
    contact = Contact(("hall", "room"), ((2, 0, 0), (2, 0, 0)))
    contacts = ContactSet.from_contacts((contact,), {"hall": 0, "room": 1})
    door = ModalityScene(wind, emitters=(Emitter("door", "hall", (0, 0, 0), 4.0),))
    felt = door.felt(("hall", "room"), contacts, [Listener("ear", "room", (3, 0, 0))], Settings())
    assert felt.values[0] == pytest.approx(4.0 * (1 - 2 / 5) * (1 - 1 / 5))
    assert wind.sensation(felt.values[0]) == "a breath"
