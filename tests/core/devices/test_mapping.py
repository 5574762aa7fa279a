"""Listeners to actuators: by body part, by choice, and every loss named."""

from dataclasses import replace

import numpy as np
import pytest
from haptic_tracing.core.devices.mapping import Loss, Place, map_listeners
from haptic_tracing.core.devices.profile_files import load_profiles, profile
from haptic_tracing.core.message import Cause, Message, sentence
from haptic_tracing.core.scene.body import BODY_PARTS, DEFAULT_LISTENERS
from hypothesis import given
from hypothesis import strategies as st
from two_tones import TWO_TONES

PROFILES = load_profiles()[0]
DEFAULT = {part: part for part in DEFAULT_LISTENERS}


def causes(mapping, listener):
    return [loss.message.cause for loss in mapping.losses if loss.listener == listener]


def test_the_twelve_default_listeners_on_a_dualsense():
    mapping = map_listeners(DEFAULT, {"pad": profile("dualsense")})
    weights = mapping.weights["pad"]
    assert weights[:, mapping.listeners.index("hand.L")].tolist() == [1.0, 0.0]
    assert weights[:, mapping.listeners.index("hand.R")].tolist() == [0.0, 1.0]
    assert weights.sum() == 2.0
    lost = {loss.listener for loss in mapping.losses if loss.message.cause is Cause.NO_ACTUATOR}
    assert lost == set(DEFAULT) - {"hand.L", "hand.R"}
    assert Loss("ear.L", Message.of(Cause.NO_ACTUATOR, body_part="ear.L")) in mapping.losses


def test_what_each_kind_of_device_loses():
    hand = {"hand.L": "hand.L"}
    assert causes(map_listeners(hand, {"a": TWO_TONES}), "hand.L") == []
    assert causes(map_listeners(hand, {"a": profile("dualsense-pcm")}), "hand.L") == []
    assert causes(map_listeners(hand, {"a": profile("dualsense")}), "hand.L") == [
        Cause.STRENGTH_ONLY
    ]
    both = {"hand.L": "hand.L", "hand.R": "hand.R"}
    assert causes(map_listeners(both, {"a": profile("xbox")}), "hand.L") == [
        Cause.SHARED_ACTUATOR,
        Cause.STRENGTH_ONLY,
        Cause.LATE,
    ]


@pytest.mark.parametrize(
    ("band", "cause"),
    [
        ((150, 300), None),
        ((160, 200), None),
        ((100, 200), Cause.PARTLY_OUT_OF_BAND),
        ((200, 400), Cause.PARTLY_OUT_OF_BAND),
        ((20, 80), Cause.OUT_OF_BAND),
    ],
)
def test_frequencies_that_an_actuator_can_not_play_are_named(band, cause):
    narrow = tuple(replace(actuator, band=(150, 300)) for actuator in TWO_TONES.actuators)
    mapping = map_listeners(
        {"seat": "hand.L"}, {"pad": replace(TWO_TONES, actuators=narrow)}, bands={"seat": band}
    )
    messages = [loss.message for loss in mapping.losses if "BAND" in loss.message.cause.name]
    limits = {"low": band[0], "high": band[1], "lowest": 150, "highest": 300}
    place = {"actuator": "left grip", "device": "Pad of two tones"}
    assert messages == ([Message.of(cause, **limits, **place)] if cause else [])


def test_a_choice_overrides_the_body_part_and_no_choice_mutes():
    (actuator,) = profile("xbox").actuators
    left = replace(profile("xbox"), actuators=(replace(actuator, body_parts=("hand.L",)),))
    devices = {"one": profile("dualsense"), "two": left}
    chosen = {"seat": [Place("one", "right grip"), Place("two", "both motors")], "hand.L": []}
    mapping = map_listeners(
        {"seat": "", "hand.L": "hand.L", "hand.R": "hand.R", "lost": ""}, devices, chosen=chosen
    )
    assert mapping.weights["one"].tolist() == [[0, 0, 0, 0], [1, 0, 1, 0]]
    assert mapping.weights["two"].tolist() == [[1, 0, 0, 0]]
    assert causes(mapping, "lost") == [Cause.NO_BODY_PART]
    sharing = {
        loss.listener for loss in mapping.losses if loss.message.cause is Cause.SHARED_ACTUATOR
    }
    assert sharing == {"seat", "hand.R"}


@given(
    parts=st.lists(
        st.sampled_from([part.name for part in BODY_PARTS]), min_size=1, max_size=25, unique=True
    ),
    names=st.lists(st.sampled_from(sorted(PROFILES)), max_size=4),
)
def test_every_listener_is_felt_or_reported_lost_and_blocks_are_sums(parts, names):
    devices = {f"device {i}": PROFILES[name] for i, name in enumerate(names)}
    mapping = map_listeners({part: part for part in parts}, devices)
    felt = {
        part
        for row, part in enumerate(parts)
        if any(weights[:, row].any() for weights in mapping.weights.values())
    }
    lost = {loss.listener for loss in mapping.losses if loss.message.cause is Cause.NO_ACTUATOR}
    assert felt | lost == set(parts) and not felt & lost
    samples = np.random.default_rng(0).normal(size=(len(parts), 7))
    for device, block in mapping.blocks(samples).items():
        for actuator, row in zip(devices[device].actuators, block, strict=True):
            expected = sum(
                (samples[parts.index(part)] for part in actuator.body_parts if part in parts),
                np.zeros(7),
            )
            assert np.allclose(row, expected, atol=1e-12)
    assert all("\n" not in sentence(loss.message) for loss in mapping.losses)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (({"a": "tail"}, {"pad": profile("dualsense")}), "body part 'tail' is unknown"),
        (({"a": ""}, {}, {"b": []}), "chosen names an unknown listener: 'b'"),
        (({"a": ""}, {}, {}, {"b": (1, 2)}), "bands names an unknown listener: 'b'"),
        (({"a": ""}, {}, {"a": [Place("pad", "left grip")]}), "device 'pad' is not connected"),
        (
            ({"a": ""}, {"pad": profile("dualsense")}, {"a": [Place("pad", "wing")]}),
            "pad has no actuator 'wing': use one of left grip",
        ),
    ],
)
def test_unknown_names_are_refused(arguments, message):
    listeners, devices, *rest = arguments
    with pytest.raises(ValueError, match=message):
        map_listeners(listeners, devices, **dict(zip(("chosen", "bands"), rest, strict=False)))


def test_samples_of_another_shape_are_refused():
    with pytest.raises(ValueError, match="samples has the shape"):
        map_listeners({"a": ""}, {}).blocks(np.zeros((2, 3)))
