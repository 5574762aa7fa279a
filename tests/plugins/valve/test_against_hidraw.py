"""A Steam Deck that umockdev makes up, through the real ``hidraw`` module."""

import sys

import pytest
from made_up_devices import DECK, KEYBOARD, Fake
from published_reports import vectors_of

VECTORS = {name: vector["hex"] for name, vector in vectors_of(__file__).items()}
pytestmark = [
    pytest.mark.skipif(
        not sys.platform.startswith("linux"), reason="umockdev and hidraw exist on Linux only"
    ),
    pytest.mark.slow,
]


def test_it_is_found(scene):
    (found,) = scene("list", fakes=[DECK])
    assert (found["title"], found["transport"]) == ("Steam Deck Controller", "usb")
    assert found["families"] == ["steam-deck"]


def test_playing_on_a_steam_deck_goes_through_feature_reports(scene):
    keyboard = Fake(3, 0x28DE, 0x1205, "Steam Deck Controller", number=0, descriptor=KEYBOARD)
    answer = scene("play", "steam-deck", "200", fakes=[DECK, keyboard])
    features = [report for report, taken in answer["features"] if taken == 65]
    assert len(features) == len(answer["features"]) == answer["written"]
    silent = VECTORS["steamdeck_rumble_l0.5_r0.25"].replace("00800040", "00000000")
    assert features[0] == features[-1] == silent
    assert VECTORS["steamdeck_rumble_l0.5_r0.25"] in features
