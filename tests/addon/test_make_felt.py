"""Make It Felt raises what reaches a listener to the wanted margin above the threshold of feeling,
and says where it can't."""

from __future__ import annotations

import bpy
import pytest
from haptic_tracing.addon.session import session, sessions
from haptic_tracing.addon.view.levels import shown_levels
from haptic_tracing.core import felt
from haptic_tracing.core.perception import sensation_level
from haptic_tracing.core.render.history import still_samples


@pytest.fixture
def weak(add_box, scene):
    """A hum that a listener on another box hardly feels, and a source beside it that it feels
    less."""
    source, carrier = (
        add_box("source", (0, 0, 0), (1, 1, 1)),
        add_box("carrier", (1, 0, 0), (1, 1, 1)),
    )
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
    assert make_felt("carrier", margin=60.0, use_frequency=False, use_material=False) == {
        "FINISHED"
    }
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


def test_the_frequency_is_changed_where_the_amplitude_is_not_enough(weak, scene):
    """Hardly anything of 8 Hz is felt."""
    source, carrier = weak
    source.haptics.source.frequency, carrier.haptics.kappa, source.haptics.kappa = 8.0, 0.9, 0.9
    bpy.context.view_layer.update()
    before = margin(scene)
    wanted = before + 45  # 20 dB of gain, 20 of amplitude
    make_felt("carrier", margin=wanted, use_material=False)
    assert margin(scene) >= wanted - 0.2
    assert (carrier.haptics.listener.gain, source.haptics.source.amplitude) == (10.0, 1.0)
    assert 40 <= source.haptics.source.frequency <= 320
    assert carrier.haptics.kappa == pytest.approx(0.9)


def test_materials_are_changed_where_all_else_is_not_enough(weak, scene):
    source, carrier = weak
    for box in weak:
        box.haptics.kappa = 0.9
    bpy.context.view_layer.update()
    assert margin(scene) + 20 < 0, "the gain alone does not make it felt"
    assert make_felt("carrier", use_amplitude=False, use_frequency=False) == {"FINISHED"}
    assert margin(scene) == pytest.approx(6, abs=0.2)
    assert source.haptics.kappa < 0.89 or carrier.haptics.kappa < 0.89


def test_nothing_changes_where_it_could_not_be_felt(weak, scene):
    """It never ends under the threshold with everything at its maximum."""
    source, carrier = weak
    for box in weak:
        box.haptics.kappa = 0.9
    bpy.context.view_layer.update()
    before = margin(scene)
    assert before + 20 < 0
    assert make_felt("carrier", use_amplitude=False, use_frequency=False, use_material=False) == {
        "CANCELLED"
    }
    assert margin(scene) == before
    assert (source.haptics.source.amplitude, carrier.haptics.listener.gain) == (
        pytest.approx(0.1),
        1.0,
    )


def test_all_selected_listeners_are_felt_by_one_press(weak, scene, add_box):
    _, carrier = weak
    others = [add_box(name, (x, 0, 0), (1, 1, 1)) for name, x in (("third", 2), ("fourth", 3))]
    for box in (carrier, *others):
        box.haptics.listener.enabled = box.haptics.listener.limiter = True
        box.haptics.listener.gain = 0.05
        box.select_set(True)
    bpy.context.view_layer.update()
    result = session.result_of(scene)
    margins = sensation_level(still_samples(result, 0.25), result.sample_rate)
    assert (margins < 0).all() and len(margins) == 3
    assert bpy.ops.haptic.make_felt() == {"FINISHED"}
    bpy.context.view_layer.update()
    result = session.result_of(scene)
    assert (sensation_level(still_samples(result, 0.25), result.sample_rate) > 5.8).all()


@pytest.mark.parametrize("in_strip", [False, True])
def test_what_is_animated_is_left_alone(weak, scene, in_strip):
    _, carrier = weak
    carrier.haptics.listener.gain = 0.1
    carrier.haptics.listener.keyframe_insert("gain", frame=1)
    if in_strip:
        data = carrier.animation_data
        action, data.action = data.action, None
        data.nla_tracks.new().strips.new("strip", 1, action)
    bpy.context.view_layer.update()
    assert make_felt("carrier") == {"CANCELLED"}
    assert carrier.haptics.listener.gain == pytest.approx(0.1)


def test_the_dialog_shows_the_changes_and_makes_none(weak, scene):
    """Planned changes are those that are made."""
    _, carrier = weak
    carrier.haptics.listener.gain = 0.05
    bpy.context.view_layer.update()
    before, traced = margin(scene), sessions.shown(scene)
    means = felt.Means(listeners=frozenset({"carrier"}), loud=frozenset({"source"}))
    planned = felt.plan(traced.result, traced.settings, "carrier", 6.0, means)
    assert planned.before == pytest.approx(before) and planned.after == pytest.approx(6, abs=0.2)
    assert carrier.haptics.listener.gain == pytest.approx(0.05)
    make_felt("carrier")
    assert margin(scene) == pytest.approx(planned.after, abs=0.01)
    (change,) = planned.changes
    assert (change.kind, change.name) == ("gain", "carrier")
    assert carrier.haptics.listener.gain == pytest.approx(change.after)
