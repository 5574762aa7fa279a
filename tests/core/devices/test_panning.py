"""Actuators in between: power is kept, the energy model holds between two, and nothing jumps."""

import dataclasses
import itertools
import json
from types import SimpleNamespace

import numpy as np
import pytest
from haptic_tracing.core.contacts.contact_set import ContactSet
from haptic_tracing.core.contacts.settings import Body
from haptic_tracing.core.contacts.shapes import Box
from haptic_tracing.core.devices.mapping import map_listeners, shares
from haptic_tracing.core.devices.profile_files import parse_profile, profile
from haptic_tracing.core.devices.profiles import Actuator, Calibration
from haptic_tracing.core.events.frame import Frame
from haptic_tracing.core.scene.values import Contact, HapticObject, Listener, Source
from haptic_tracing.core.tracer import Tracer
from hypothesis import given
from hypothesis import strategies as st

PAIR = [(0.0, 0.0), (1.0, 0.0)]
VEST = [(k % 4 / 3, k // 4 / 4) for k in range(20)]
LAYOUTS = {
    "pair": PAIR,
    "diagonal": [(0, 0), (3, 2)],
    "vest": VEST,
    "ring": [(np.cos(k), np.sin(k)) for k in range(6)],
}
unit = st.floats(0, 1)


def device(positions, part="middle_back.L"):
    actuators = tuple(
        Actuator(
            f"m{k}",
            (part,),
            "ERM",
            (30.0, 250.0),
            0.05,
            1.0,
            (),
            Calibration(),
            position=None if at is None else tuple(map(float, at)),
        )
        for k, at in enumerate(positions)
    )
    return SimpleNamespace(title="vest", actuators=actuators, plays_frequency=False)


def mapped(positions):
    return map_listeners({"back": "middle_back.L"}, {"vest": device(positions)})


@given(beta=unit)
def test_two_actuators_follow_the_energy_model(beta):
    """A1 = sqrt(1 - beta) A, A2 = sqrt(beta) A, and A1^2 + A2^2 = A^2."""
    place = np.array([[beta, 0.5]])
    block = mapped(PAIR).blocks(np.full((1, 4), 0.8), place, place)["vest"]
    assert block[0] == pytest.approx(np.sqrt(1 - beta) * 0.8, abs=1e-12)
    assert block[1] == pytest.approx(np.sqrt(beta) * 0.8, abs=1e-12)
    assert (block**2).sum(axis=0) == pytest.approx(0.64, rel=1e-12)


@pytest.mark.parametrize("layout", LAYOUTS)
@given(before=st.tuples(unit, unit), after=st.tuples(unit, unit))
def test_power_is_kept_at_every_sample_while_the_place_moves(layout, before, after):
    samples = np.sin(np.arange(64))[None]
    block = mapped(LAYOUTS[layout]).blocks(samples, np.array([before]), np.array([after]))["vest"]
    np.testing.assert_allclose((block**2).sum(axis=0), samples[0] ** 2, rtol=0, atol=1e-12)
    assert (np.abs(block) <= np.abs(samples) + 1e-12).all()


@pytest.mark.parametrize("layout", LAYOUTS)
@given(place=st.tuples(unit, unit), step=st.tuples(st.floats(-1, 1), st.floats(-1, 1)))
def test_a_small_step_changes_the_powers_a_little(layout, place, step):
    positions = np.array(LAYOUTS[layout], dtype=float)
    near = np.clip(np.array(place) + 1e-4 * np.array(step), 0, 1)
    assert np.abs(shares(positions, np.array(place)) - shares(positions, near)).max() < 0.01


def test_at_an_actuator_it_plays_alone_and_between_rows_and_columns_the_four_about_it_do():
    positions = np.array(VEST)
    for k, place in enumerate(VEST):
        assert shares(positions, np.array(place)) == pytest.approx(np.eye(20)[k], abs=1e-12)
    middle = shares(positions, np.array([0.5, 0.125]))
    assert np.flatnonzero(middle > 1e-12).tolist() == [1, 2, 5, 6] and middle[
        [1, 2, 5, 6]
    ] == pytest.approx(0.25)


def test_blocks_join_without_a_step():
    mapping, places = mapped(VEST), [np.array([[x, 0.4]]) for x in (0.1, 0.5, 0.9)]
    blocks = [
        mapping.blocks(np.ones((1, 100)), *pair)["vest"] for pair in itertools.pairwise(places)
    ]
    joined = np.concatenate(blocks, axis=1) ** 2
    assert np.abs(np.diff(joined, axis=1)).max() < 0.02


def test_without_positions_all_play_alike_as_before():
    place = np.array([[0.2, 0.2]])
    for positions in ([None, None], [None, (0, 0)]):
        mapping = mapped(positions)
        assert mapping.blocks(np.ones((1, 2)), place, place)["vest"].tolist() == [[1, 1], [1, 1]]
    assert not mapped([None, None]).pans and not any(
        map_listeners({}, {"d": profile("dualsense")}).pans for _ in "x"
    )
    assert mapped(PAIR).blocks(np.ones((1, 2)))["vest"].tolist() == [[1, 1], [1, 1]], (
        "no place is known"
    )


def test_a_profile_of_the_users_own_may_have_positions(tmp_path):
    from haptic_tracing.core.devices.profile_files import BUILT_IN

    document = json.loads((BUILT_IN / "dualsense.json").read_text())
    for actuator, x in zip(document["actuators"], (0, 1), strict=True):
        actuator["position"], actuator["body_parts"] = [x, 0], ["belly"]
    assert [
        item.position for item in parse_profile(json.dumps(document).encode(), "pad.json").actuators
    ] == [(0, 0), (1, 0)]
    document["actuators"][0]["position"] = [0]
    with pytest.raises(ValueError, match="/actuators/0/position"):
        parse_profile(json.dumps(document).encode(), "pad.json")


def traced(places, **listener):
    """What sources that reach a back through contacts at ``places`` make of a frame."""
    objects = HapticObject("back", 0, 1), *(HapticObject(f"o{k}", 0, 1) for k in range(len(places)))
    contacts = [Contact((f"o{k}", "back"), (place, place)) for k, place in enumerate(places)]
    index = {name: k for k, name in enumerate(sorted(item.name for item in objects))}
    heard = Listener("l", "back", (0, 0, 1), radius=0.1, **listener)
    sources = tuple(Source(f"s{k}", f"o{k}", place) for k, place in enumerate(places))
    return Tracer().step(
        Frame(
            1, 0.0, objects, sources, (heard,), contacts=ContactSet.from_contacts(contacts, index)
        )
    )


def test_where_a_contact_arrives_in_the_volume():
    """A body faces -Y: its left is at +X; above is 0."""
    for place, expected in (
        ((0, 0.1, 1), (0.5, 0.5)), ((0.1, 0, 1), (0, 0.5)), ((-0.05, 0, 1), (0.75, 0.5)), ((0, 0, 1.1), (0.5, 0)), ((3, 0, -2), (0, 1)),
    ):  # fmt: skip
        assert traced([place]).arrivals()[0] == pytest.approx(expected, abs=1e-12), place
    assert traced([]).arrivals().tolist() == [[0.5, 0.5]]


def test_where_it_arrives_turns_with_the_body():
    """A box that touches the wearer's left side, both turned about the vertical."""
    shaft = HapticObject("back", 0, 1, shape=Box((0.2, 0.2, 0.4)))
    hand = HapticObject("hand", 0, 1, shape=Box((0.1, 0.1, 0.1)))
    for angle in (0.0, 0.5, np.pi / 2, np.pi):
        way = np.array([np.cos(angle), np.sin(angle), 0.0])
        transforms = np.tile(np.eye(4), (2, 1, 1))
        transforms[:, :2, :2] = [[way[0], -way[1]], [way[1], way[0]]]
        transforms[1, :3, 3] = 0.15 * way
        frame = Frame(
            1,
            0.0,
            (shaft, hand),
            (Source("s", "hand", tuple(0.15 * way)),),
            (Listener("l", "back", (0, 0, 0), radius=0.1),),
            bodies=(Body.of(shaft, shaft.shape), Body.of(hand, hand.shape)),
            transforms=transforms,
        )
        assert Tracer().step(frame).arrivals()[0] == pytest.approx((0, 0.5), abs=1e-9), angle


def test_several_arrivals_count_by_their_power():
    result = traced([(0.1, 0, 1), (-0.1, 0, 1)])
    assert result.arrivals()[0] == pytest.approx((0.5, 0.5))
    quiet = dataclasses.replace(result, amplitudes=result.amplitudes * [[1.0], [0.5]])
    assert quiet.arrivals()[0, 0] == pytest.approx(0.2), (
        "4 of 5 parts of the power come from the left"
    )


def test_a_moving_contact_moves_the_pan_smoothly():
    places = [traced([(x, 0, 1)]).arrivals()[0, 0] for x in np.linspace(0.15, -0.15, 61)]
    assert (
        np.all(np.diff(places) >= 0)
        and np.abs(np.diff(places)).max() < 0.03
        and places[0] == 0
        and places[-1] == 1
    )
