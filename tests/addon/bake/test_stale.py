"""A track says that the scene has changed since, and what."""

import bpy
import pytest
from haptic_tracing.addon.bake import playback


def _reasons(scene):
    bpy.context.view_layer.update()
    return playback.stale_reasons(scene)


@pytest.fixture
def baked(shaken):
    bpy.ops.haptic.bake()
    return shaken


def test_a_fresh_bake_is_not_stale_in_any_frame(baked):
    for frame in (1, 5, 13, 24):
        baked.frame_set(frame)
        assert _reasons(baked) == ()


def _move(scene):
    bpy.data.objects["ground"].location.x += 1


def _kappa(scene):
    bpy.data.objects["crate"].haptics.kappa = 0.4


def _bands(scene):
    bpy.data.objects["crate"].haptics.material.use_bands = True


def _refractory(scene):
    scene.haptics.refractory_time = 0.5


def _mute(scene):
    bpy.data.objects["shaker"].haptics.source.muted = True


def _key(scene):
    crate = bpy.data.objects["crate"]
    crate.location.z = 3.0
    crate.keyframe_insert("location", frame=14)


def _mesh(scene):
    bpy.data.objects["crate"].data.vertices[0].co.x -= 0.1


def _parent(scene):
    bpy.data.objects["foot"].parent = None


def _add(scene):
    obj = bpy.data.objects["crate"].copy()
    obj.name = "other"
    scene.collection.objects.link(obj)


def _remove(scene):
    bpy.data.objects.remove(bpy.data.objects["hand"])


def _threshold(scene):
    scene.haptics.threshold = 0.01


def _rate(scene):
    scene.render.fps = 30


def _gravity(scene):
    scene.gravity.z = -1.6


def _range(scene):
    scene.frame_end = 99


@pytest.mark.slow
@pytest.mark.parametrize(
    ("change", "words"),
    [
        (_move, "'ground': it was moved, turned or scaled"),
        (_kappa, "'crate': its haptic settings changed"),
        (_bands, "'crate': its haptic settings changed"),
        (_refractory, "refractory time was 0.1, is 0.5"),
        (_mute, "'shaker': its haptic settings changed"),
        (_key, "'crate': its animation changed"),
        (_mesh, "'crate': its shape changed"),
        (_parent, "'foot': its parent, constraints or modifiers changed"),
        (_add, "'other' was added"),
        (_remove, "'hand' was removed"),
        (_threshold, "threshold was 0.001, is 0.01"),
        (_rate, "the frame rate changed"),
        (_gravity, "gravity changed"),
        (_range, "frames 1 to 99 are played, 1 to 24 were baked"),
    ],
)
def test_every_change_is_named(baked, change, words):
    change(baked)
    assert _reasons(baked) == (words,)
    bpy.ops.haptic.bake()
    assert _reasons(baked) == ()


def test_selecting_cameras_and_colours_changes_nothing(baked):
    bpy.data.objects["crate"].select_set(True)
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    baked.collection.objects.link(camera)
    bpy.data.objects["crate"].color = (1, 0, 0, 1)
    baked.haptics.show_labels = not baked.haptics.show_labels
    assert _reasons(baked) == ()


def test_many_changes_are_a_short_list(baked):
    for number in range(20):
        obj = bpy.data.objects["crate"].copy()
        obj.name = f"copy {number}"
        baked.collection.objects.link(obj)
    reasons = _reasons(baked)
    assert len(reasons) == 7
    assert reasons[-1] == "and 14 more"


def test_a_strange_digest_is_stale_not_an_error(baked):
    from haptic_tracing.addon.scene_reader.digest import changes, digest_of

    for strange in ({}, {"objects": 3, "settings": []}, {"objects": {"crate": None}}):
        assert changes(strange, digest_of(baked))


def test_a_draw_compares_nothing_but_has_it_done_after_the_redraw(baked, monkeypatch):
    bpy.context.view_layer.update()
    compare = playback.compare
    monkeypatch.setattr(playback, "compare", lambda *_: pytest.fail("a draw compares the scene with its track"))
    assert playback.known_stale_reasons(baked) is None
    assert bpy.app.timers.is_registered(playback._compare_shown)
    monkeypatch.setattr(playback, "compare", compare)
    playback._compare_shown()
    assert playback.known_stale_reasons(baked) == ()
    _kappa(baked)
    assert playback.known_stale_reasons(baked) == (), "what was known, until the comparison is made again"
    playback._compare_shown()
    assert playback.known_stale_reasons(baked) == ("'crate': its haptic settings changed",)
