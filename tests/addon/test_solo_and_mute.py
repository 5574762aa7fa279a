"""Solo and mute of sources and listeners: who is silenced, and that a click brings all back."""

from __future__ import annotations

import bpy
import pytest
from haptic_tracing.addon.session import session
from haptic_tracing.addon.view import explanation


@pytest.fixture
def hums(add_box, scene):
    """Two sources on a plank, two listeners."""
    plank = add_box("plank", (0, 0, 0), (4, 1, 0.2))
    for name, x in (("left", -1.5), ("right", 1.5)):
        box = add_box(name, (x, 0, 0.35), (0.5, 0.5, 0.5))
        box.haptics.source.enabled = box.haptics.listener.enabled = True
    bpy.context.view_layer.update()
    return plank, scene.objects["left"].haptics, scene.objects["right"].haptics


def felt(scene):
    """By source and listener: whether anything is felt, gain of the listener included."""
    bpy.context.view_layer.update()
    result = session.result_of(scene)
    return [
        [
            bool(gain * listener.gain > 0)
            for gain, listener in zip(row, result.listeners, strict=True)
        ]
        for row in result.amplitudes
    ]


ALL = [[True, True], [True, True]]


@pytest.mark.parametrize(
    ("role", "of_left", "of_both"),
    [
        ("source", [[True, True], [False, False]], ALL),
        ("listener", [[True, False], [True, False]], ALL),
    ],
)
def test_solo_silences_the_others_of_its_role(hums, scene, role, of_left, of_both):
    _, left, right = hums
    assert felt(scene) == ALL
    getattr(left, role).solo = True
    assert felt(scene) == of_left
    getattr(right, role).solo = True
    assert felt(scene) == of_both
    getattr(left, role).muted = True  # mute comes before solo
    assert felt(scene) != of_both
    getattr(left, role).solo = getattr(left, role).muted = getattr(right, role).solo = False
    assert felt(scene) == ALL


def test_mute_silences_a_listener_alone_and_why_is_it_silent_says_so(hums, scene):
    _, left, _ = hums
    left.listener.muted = True
    assert felt(scene) == [[False, True], [False, True]]
    assert "muted" in explanation.why_silent(scene, "left").notice
    assert explanation.why_silent(scene, "right").notice == ""


def test_what_has_no_role_any_more_silences_nobody(hums, scene):
    _, left, _ = hums
    left.source.solo = True
    left.source.enabled = False
    assert felt(scene) == [[True, True]]


def test_a_solo_source_silences_impacts_and_gives_them_back(add_box, add_empty, scene):
    ground = add_box("ground", (0, 0, -0.5), (4, 4, 1), "PASSIVE")
    ball = add_box("ball", (0, 0, 0.8), (0.4, 0.4, 0.4), "ACTIVE", mass=5.0)
    hum = add_empty("hum", (0.2, 0, 0.5), ground)
    hum.haptics.source.enabled = ball.haptics.listener.enabled = True
    scene.frame_set(1)
    while not session.result_of(scene).impacts:
        scene.frame_set(scene.frame_current + 1)
        assert scene.frame_current < 50
    names = [item.name for item in session.result_of(scene).sources]
    assert len(names) == 2
    hum.haptics.source.solo = True
    bpy.context.view_layer.update()
    assert [item.name for item in session.result_of(scene).sources] == ["hum"]
    hum.haptics.source.solo = False
    bpy.context.view_layer.update()
    assert [item.name for item in session.result_of(scene).sources] == names
