"""What a ``.tact`` file plays: strengths at multiples of 20 ms, as the maker's program writes them
into its files."""

from __future__ import annotations

import json

import numpy as np
import pytest
from haptic_tracing.core.formats.tracks import tact

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
    mode = path((0, 0, 1.0, 0), (0, 0, 1.0, 90), (0, 0, 1.0, 190), fade="FADE_OUT")
    assert played(tmp_path, [(0, 190, mode)], [0, 80, 100, 160]) == pytest.approx(
        [1.0, 1 / 9, 0.9, 0.3]
    )


def test_paths_that_play_together_add_up_to_at_most_1(tmp_path):
    def effect(strength):
        return (0, 100, path((0, 0, strength, 0), (0, 0, strength, 100)))

    assert played(tmp_path, [effect(0.3), effect(0.4)], [40]) == pytest.approx([0.7])
    assert played(tmp_path, [effect(0.7), effect(0.7)], [40]) == [1.0]


def test_a_point_between_motors_is_played_by_three_of_them():
    """Every point has non-negative weights on the corners of one triangle; on a motor only that one
    plays (up to the shift)."""
    places = tact._LAYOUTS["VestFront"]
    x, y = np.random.default_rng(1).random((2, 500))
    weights = tact._weights(places, x, y)
    assert ((weights > 1e-12).sum(axis=0) <= 3).all()
    barycentric = weights ** (1 / tact.SPREAD)
    assert barycentric.sum(axis=0) == pytest.approx(np.ones(500))
    columns = np.array(places).T @ barycentric
    inside = (x > 0.02) & (y > 0.02)
    shift = np.array([[tact.ROUNDED_DOWN / 3], [tact.ROUNDED_DOWN / 4]])
    assert (columns + shift)[:, inside] == pytest.approx(np.array([x, y])[:, inside])
