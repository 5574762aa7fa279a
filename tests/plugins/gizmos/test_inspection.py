"""What is under the mouse in the overlay, against the scene's own functions and SciPy-free geometry."""

import math

import numpy as np
import pytest
from haptic_tracing.addon.session import sessions
from haptic_tracing.core.message import Metres, written
from haptic_tracing.plugins.gizmos import inspection
from in_blender import ALPHA

NEPER = 20 / math.log(10)


def test_links_say_distance_loss_and_gain(drill_and_hand):
    """Losses are alpha times the distance, whatever the amplitude; the source is at 0, and at the
    listener they have added up."""
    found = inspection.links_of(sessions.shown(drill_and_hand))
    drill, hand = sorted(item for item in found.items if item.first in ("drill", "hand"))
    links = found._replace(items=tuple(item for item in found.items if item not in (drill, hand)))
    assert drill[4:] == (0.0, 0.0, 0.0)
    assert hand.distance == pytest.approx(sum(link.distance for link in links.items))
    assert hand.loss == pytest.approx(sum(link.loss for link in links.items)) == -hand.gain
    inside = {link.first: link for link in links.items if link.first == link.second}
    assert inside.keys() == ALPHA.keys()
    for name, link in inside.items():
        assert link.loss == pytest.approx(NEPER * ALPHA[name] * link.distance)
        assert (link.source, link.listener) == ("drill", "hand")
        assert inspection.words_of(link)[0] == name
        assert written(Metres(link.distance)) in inspection.words_of(link)[1]
    assert sum(link.distance for link in links.items) == pytest.approx(3.6, abs=0.3)
    last = min(links.items, key=lambda link: link.gain)
    assert last.gain == pytest.approx(-sum(link.loss for link in links.items))
    assert last.gain == pytest.approx(
        20 * math.log10(sessions.shown(drill_and_hand).result.gains[0, 0])
    )
    (contact,) = (link for link in links.items if link.first != link.second)
    assert inspection.words_of(contact)[0] == "left × right"


def test_distances_to_segments_against_dense_sampling():
    random = np.random.default_rng(5)
    ends, place = random.uniform(-9, 9, (40, 2, 2)), np.array([0.7, -1.2])
    ends[0, 1] = ends[0, 0]  # a segment of no length
    share = np.linspace(0, 1, 20_001)[:, None, None]
    dense = np.linalg.norm(ends[:, 0] * (1 - share) + ends[:, 1] * share - place, axis=2)
    assert inspection.distances_to(place, ends) == pytest.approx(dense.min(axis=0), abs=1e-3)
    ends[3, 1] = np.nan
    assert np.isnan(inspection.distances_to(place, ends)[3])
