"""Two actuators at one hand, by a profile of the user's own: they share what is felt there by where
it arrives, and the body shows them."""

import json

import numpy as np
import pytest
from haptic_tracing.addon.live_output import player
from haptic_tracing.addon.operators import live_output
from haptic_tracing.addon.view.levels import Level
from haptic_tracing.addon.view.meter_layout import meter_hud
from haptic_tracing.core.devices.profile_files import BUILT_IN


@pytest.fixture
def one_hand(tmp_path, monkeypatch):
    """DualSenses whose grips both lie at the left hand, side by side."""
    document = json.loads((BUILT_IN / "dualsense.json").read_text())
    for actuator, x in zip(document["actuators"], (0, 1), strict=True):
        actuator["position"], actuator["body_parts"] = [x, 0], ["hand.L"]
    (tmp_path / "dualsense.json").write_text(json.dumps(document))
    monkeypatch.setattr(
        live_output, "profile_folders", lambda: (tmp_path,)
    )  # as where the add-on is an extension


def test_actuators_share_what_arrives_between_them(one_hand, felt, plug, connect, playing):
    assert player.spots() == ()
    hand = next(obj for obj in felt.objects if obj.haptics.listener.body_part == "hand.L")
    hand.haptics.listener.radius = 0.2
    plug()
    connect()
    # The source at the middle is so far to the wearer's left.
    for place, left in ((-0.1, 0.75), (0.0, 0.5), (0.1, 0.25), (0.3, 0.0)):
        hand.location.x = place
        playing()
        playing()
        spots = player.spots()
        assert [(spot.part, spot.across, spot.down) for spot in spots] == [
            ("hand.L", 0.0, 0.0),
            ("hand.L", 1.0, 0.0),
        ]
        assert [spot.amplitude**2 for spot in spots] == pytest.approx([left, 1 - left], abs=1e-5)
    player.stop()
    assert player.spots() == ()


def test_the_body_shows_them_as_bright_as_they_play(one_hand, felt, plug, connect, playing):
    plug()
    connect()
    playing(2)
    level = Level("left", "left", "hand.L", -6.0, 30.0)
    plain, shown = (
        meter_hud([level], (1200, 600), 1.0, spots=spots).lines for spots in ((), player.spots())
    )
    assert len(shown.width) - len(plain.width) == 4, "two actuators, from the front and from behind"
    points = np.isclose(shown.width, 2.5) & (shown.position[:, 0] == shown.position[:, 1]).all(
        axis=1
    )
    assert points.sum() == 4
