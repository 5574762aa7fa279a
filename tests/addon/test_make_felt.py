"""Make It Felt raises what reaches a listener to the wanted margin above the threshold of feeling, and says where it can't."""

from __future__ import annotations

import bpy
import pytest
from haptic_tracing.addon.session import session, sessions
from haptic_tracing.addon.view.levels import shown_levels
from haptic_tracing.core.perception import sensation_level
from haptic_tracing.core.render.history import still_samples


@pytest.fixture
def weak(add_box, scene):
    """A hum that a listener on another box hardly feels, and a source beside it that it feels less."""
    source, carrier = add_box("source", (0, 0, 0), (1, 1, 1)), add_box("carrier", (1, 0, 0), (1, 1, 1))
    source.haptics.source.enabled = carrier.haptics.listener.enabled = True
    source.haptics.source.amplitude, source.haptics.source.frequency = 0.1, 60.0
    carrier.haptics.listener.limiter = True
    bpy.context.view_layer.update()
    return source, carrier


def margin(scene):
    """By its definition: of a quarter second at the gains of the frame."""
    result = session.result_of(scene)
    return float(sensation_level(still_samples(result, 0.25), result.sample_rate)[0])


def make_felt(listener, **options):
    done = bpy.ops.haptic.make_felt(listener=listener, **options)
    bpy.context.view_layer.update()
    return done


def test_the_gain_of_the_listener_is_enough(weak, scene):
    source, carrier = weak
    before = margin(scene)
    carrier.haptics.listener.gain = 10 ** (-(before + 4) / 20)  # 4 dB too weak
    bpy.context.view_layer.update()
    assert margin(scene) == pytest.approx(-4, abs=0.2)
    assert make_felt("carrier") == {"FINISHED"}
    assert margin(scene) == pytest.approx(6, abs=0.2)
    assert source.haptics.source.amplitude == pytest.approx(0.1)


def test_the_amplitude_of_the_source_is_raised_where_there_is_no_more_gain(weak, scene):
    source, carrier = weak
    carrier.haptics.listener.gain = 10.0
    bpy.context.view_layer.update()
    wanted = margin(scene) + 10
    assert make_felt("carrier", margin=wanted) == {"FINISHED"}
    assert margin(scene) == pytest.approx(wanted, abs=0.2)
    assert source.haptics.source.amplitude == pytest.approx(0.1 * 10**0.5, rel=0.05)
    assert carrier.haptics.listener.gain == 10.0


def test_it_stops_at_what_can_be_raised(weak, scene):
    source, carrier = weak
    assert make_felt("carrier", margin=60.0) == {"FINISHED"}
    assert (source.haptics.source.amplitude, carrier.haptics.listener.gain) == (1.0, 10.0)
    assert margin(scene) < 60


def test_what_is_felt_enough_stays_as_it_is(weak, scene):
    source, carrier = weak
    source.haptics.source.amplitude = 1.0
    bpy.context.view_layer.update()
    assert margin(scene) > 6
    make_felt("carrier")
    assert carrier.haptics.listener.gain == 1.0


def test_nothing_is_raised_where_nothing_arrives(weak, scene):
    _, carrier = weak
    carrier.location.x = 5.0
    bpy.context.view_layer.update()
    assert make_felt("carrier") == {"CANCELLED"}
    assert carrier.haptics.listener.gain == 1.0


def test_the_panel_shows_what_was_reached(weak, scene):
    make_felt("carrier")
    (level,) = shown_levels(sessions.shown(scene), False)
    assert level.is_felt and level.margin == pytest.approx(margin(scene))
