"""What a ``.tact`` file plays: strengths at multiples of 20 ms, as the maker's program writes them
into its files."""

from __future__ import annotations

import json

import numpy as np
import pytest
from haptic_tracing.plugins.bhaptics import tact

LAYOUT = {"name": "Tactosy2", "type": "Tactosy2", "layouts": {"ForearmL": []}}


def played(tmp_path, effects, times):
    """The strengths of the left forearm at ``times`` (milliseconds) of a file with ``effects``:
    (start, length, mode)."""
    tracks = [
        {"effects": [{"startTime": start, "offsetTime": length, "modes": {"ForearmL": mode}}]}
        for start, length, mode in effects
    ]
    document = {
        "project": {"layout": LAYOUT, "tracks": tracks},
        "durationMillis": 1000,
        "intervalMillis": 20,
        "size": 20,
    }
    path = tmp_path / "a.tact"
    path.write_text(json.dumps(document))
    channels = tact.read(path).channels
    if not channels:
        return [0.0] * len(times)
    (carrier,) = channels[0].carriers
    middles = np.array(times) / 1000 + 0.01
    return np.where(
        middles < carrier.end, np.interp(middles, carrier.amplitude_times, carrier.amplitudes), 0.0
    ).tolist()


def dots(*intervals, connected=False):
    feedback = [
        {
            "startTime": start,
            "endTime": end,
            "playbackType": fade,
            "pointList": [{"index": i, "intensity": x} for i, x in points],
        }
        for start, end, fade, points in intervals
    ]
    return {
        "mode": "DOT_MODE",
        "dotMode": {"dotConnected": connected, "feedback": feedback},
        "pathMode": {"feedback": []},
    }


def path(*points, fade="NONE"):
    keys = [
        {"x": x, "y": y, "intensity": strength, "time": time} for x, y, strength, time in points
    ]
    feedback = [
        {"movingPattern": "CONST_SPEED", "playbackType": fade, "visible": True, "pointList": keys}
    ]
    return {
        "mode": "PATH_MODE",
        "dotMode": {"dotConnected": False, "feedback": []},
        "pathMode": {"feedback": feedback},
    }


def test_a_path_of_one_point_is_there_for_the_whole_effect(tmp_path):
    assert played(tmp_path, [(0, 200, path((0.0, 0.0, 0.8, 0)))], [0, 100, 180]) == pytest.approx(
        [0.8] * 3
    )


def test_the_fade_of_a_single_point_spans_the_effect(tmp_path):
    effect = (40, 200, path((0.0, 0.0, 1.0, 0), fade="FADE_OUT"))
    assert played(tmp_path, [effect], [0, 40, 140, 220]) == pytest.approx([0.0, 1.0, 0.5, 0.1])


def test_connected_dots_blend_linearly(tmp_path):
    """One motor falls while the next one rises; the part plays the stronger of the two."""
    mode = dots(
        (0, 100, "NONE", [(0, 1.0)]),
        (100, 200, "FADE_OUT", [(1, 0.6)]),
        (200, 200, "NONE", []),
        connected=True,
    )
    assert played(tmp_path, [(0, 200, mode)], [0, 20, 60, 80, 160]) == pytest.approx(
        [1.0, 0.8, 0.4, 0.48, 0.24]
    )


def test_a_fade_begins_anew_at_each_point_of_a_path(tmp_path):
    """A ninth of it is 11 %: each dot and path adds whole percents, rounded down."""
    mode = path((0, 0, 1.0, 0), (0, 0, 1.0, 90), (0, 0, 1.0, 190), fade="FADE_OUT")
    assert played(tmp_path, [(0, 190, mode)], [0, 80, 100, 160]) == pytest.approx(
        [1.0, 0.11, 0.9, 0.3]
    )


def test_paths_that_play_together_add_up_to_at_most_1(tmp_path):
    def effect(strength):
        return (0, 100, path((0, 0, strength, 0), (0, 0, strength, 100)))

    assert played(tmp_path, [effect(0.3), effect(0.4)], [40]) == pytest.approx([0.7])
    assert played(tmp_path, [effect(0.7), effect(0.7)], [40]) == [1.0]


FRAMES = (
    (0.0, 2.016, 90, {8: 90}),
    (0.144, 0.977, 90, {0: 9, 1: 4, 4: 81}),
    (0.234, 1.001, 90, {1: 13, 4: 74, 5: 13}),
    (0.326, 3.043, 70, {12: 48, 13: 21, 16: 7}),
    (0.708, 2.083, 90, {8: 36, 9: 54, 12: 11}),
    (1.098, 2.799, 90, {9: 27, 10: 9, 13: 63}),
    (1.338, 2.76, 90, {9: 16, 10: 22, 13: 66}),
    (1.554, 0.263, 90, {1: 33, 2: 50, 5: 27}),
    (1.704, 0.727, 90, {2: 35, 5: 43, 6: 35}),
    (1.923, 0.217, 70, {1: 10, 2: 57, 5: 10}),
    (2.034, 1.318, 90, {6: 72, 7: 7, 10: 18}),
    (2.76, 3.547, 90, {15: 50, 18: 33, 19: 27}),
    (2.994, 0.507, 90, {3: 57, 6: 18, 7: 30}),
)
"""Points on the front of a vest, (x, y) in distances of motors and a strength, and the strengths of
the motors in frames that the maker's program wrote into its files Swirl and Circle; all in
percent, rounded down."""


@pytest.mark.parametrize(("x", "y", "strength", "frame"), FRAMES)
def test_motors_play_a_point_between_them_as_in_frames_of_the_maker(x, y, strength, frame):
    weights = tact._weights(tact._LAYOUTS["VestFront"], np.array([x / 3]), np.array([y / 4]))[:, 0]
    expected = np.zeros(20)
    expected[list(frame)] = list(frame.values())
    assert strength * weights == pytest.approx(expected + 0.5 * (expected > 0), abs=0.75)


@pytest.mark.parametrize("position", ["VestFront", "Head", "ForearmL", "HandL", "FootR"])
def test_a_point_on_the_first_or_the_last_motor_is_played_by_it_alone(position):
    places = tact._LAYOUTS[position]
    x, y = np.array([places[0], places[-1]]).T
    expected = np.eye(len(places))[:, [0, -1]]
    assert tact._weights(places, x, y) == pytest.approx(expected, abs=1e-6)


def test_a_point_is_played_by_at_most_three_motors_with_at_least_its_strength():
    x, y = np.random.default_rng(1).random((2, 500))
    weights = tact._weights(tact._LAYOUTS["VestFront"], x, y)
    assert ((weights > 1e-5).sum(axis=0) <= 3).all()
    assert ((weights.sum(axis=0) > 0.9999) & (weights.sum(axis=0) < 1.3)).all()
