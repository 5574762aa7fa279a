"""The table of textures in Blender: what slides and rolls plays by it, a bake has the same bits
whatever its range, files play alike."""

import bpy
import numpy as np
import pytest
from haptic_tracing.addon.bake import storage
from haptic_tracing.addon.session import session, sessions, timeline
from haptic_tracing.core.formats.haptic_scene import read_export
from haptic_tracing.core.formats.scene.recording import traced
from haptic_tracing.core.render.integers import as_integers
from scene_files import exported

LAST = 80


@pytest.fixture
def crate(scene, add_box, add_empty):
    """A wooden crate that is dragged over concrete along a curve, at 24 frames a second, and stands
    for the last ten; a hand on it."""
    bpy.ops.rigidbody.world_add()
    ground = add_box("ground", (0, 0, -0.5), (20, 20, 1), "PASSIVE")
    crate = add_box("crate", (0, 0, 0.25), (0.5, 0.5, 0.5), "PASSIVE", mass=20.0)
    crate.rigid_body.kinematic = True
    ground.haptics.material.name, crate.haptics.material.name = "Concrete", "Softwood"
    add_empty("hand", (0, 0, 0.25), crate).haptics.listener.enabled = True
    for frame in range(1, LAST - 9):
        crate.location = (0.02 * frame, np.sin(frame / 20), 0.25)
        crate.keyframe_insert("location", frame=frame)
    scene.frame_start, scene.frame_end = 1, LAST
    return crate


def add_texture(scene, **properties):
    row = scene.haptics.textures.items.add()
    for name, value in properties.items():
        setattr(row, name, value)
    return row


def play(scene, last=8, first=1):
    results = []
    scene.frame_set(first - 1)
    for frame in range(first, last + 1):
        scene.frame_set(frame)
        results.append(session.result_of(scene))
    return results


def problems(scene):
    return {problem.rule: problem.message for problem in sessions.shown_problems(scene)}


def test_without_rules_nothing_slides(scene, crate):
    assert not any(result.sources for result in play(scene))


def test_what_is_dragged_plays_while_it_moves_and_then_not_at_all(scene, crate):
    add_texture(scene, period=0.01, noise=0.0)
    results = play(scene, LAST)
    assert {source.name for source in results[10].sources} == {
        "crate sliding on ground",
        "ground sliding on crate",
    }
    assert all(result.block.any() for result in results[3:60])
    assert not any(result.sources or result.block.any() for result in results[LAST - 7 :])


@pytest.mark.slow
def test_a_range_traced_alone_has_the_bits_of_the_whole(scene, crate):
    add_texture(scene, noise=0.4)
    assert bpy.ops.haptic.bake() == {"FINISHED"}
    whole = storage.track_of(scene)
    results = timeline.results(scene, 60, 76 + 1)
    blocks = [as_integers(result.block) for result in results if result.block is not None]
    alone = np.concatenate(blocks, axis=1)
    assert alone.any()
    assert np.array_equal(alone, whole.samples[:, whole.offsets[60] : whole.offsets[77]])
    assert {source.name for source in whole.sources} == {
        "crate sliding on ground",
        "ground sliding on crate",
    }


def test_one_click_adds_the_textures_of_all_materials(scene, crate):
    assert bpy.ops.haptic.add_textures() == {"FINISHED"}
    rows = scene.haptics.textures.items
    assert [(row.first_kind, row.first, row.second_kind) for row in rows] == [
        ("MATERIAL", "Concrete", "ANY"),
        ("MATERIAL", "Softwood", "ANY"),
    ]
    assert [row.period for row in rows] == pytest.approx([0.002, 0.0018])
    assert bpy.ops.haptic.add_textures() == {"CANCELLED"}
    assert problems(scene) == {} and play(scene)[-1].sources
    bpy.context.view_layer.objects.active = crate
    assert bpy.ops.haptic.add_rule(table="textures") == {"FINISHED"}
    assert rows[2].first == "Softwood" and rows[2].period == pytest.approx(0.0018)


@pytest.mark.parametrize(
    ("row", "words"),
    [({"first_kind": "OBJECT", "first": "anvil"}, "there is no haptic object 'anvil'"),
     ({"first_kind": "MATERIAL", "first": "Cheese"}, "nothing is made of a material 'Cheese'"),
     ({"first_kind": "OBJECT", "first": ""}, "choose what this rule is for")],
)  # fmt: skip
def test_what_is_wrong_is_said_beside_the_row_and_the_rest_goes_on(scene, crate, row, words):
    add_texture(
        scene, first_kind="OBJECT", first="crate", sliding=0.25, full_force=0.1, full_speed=0.01
    )
    add_texture(scene, **row)
    assert play(scene)[-1].sources[-1].amplitude == 0.25
    assert words in problems(scene)["textures", 1]


def test_a_frame_that_is_looked_at_follows_an_edit_of_its_texture(scene, crate):
    row = add_texture(scene, sliding=0.2, full_force=0.1, full_speed=0.01)
    play(scene)
    row.sliding = 0.4
    scene.frame_set(scene.frame_current)
    assert max(source.amplitude for source in session.result_of(scene).sources) == pytest.approx(
        0.4
    )
    row.period = 0.003
    results = [session.result_of(scene)]
    for frame in (9, 10):
        scene.frame_set(frame)
        results.append(session.result_of(scene))
    assert len(results[-1].sources) == 2 and results[-1].block.any()


def slides(scene):
    return [
        (item.name, item.onset, item.amplitude, item.signal)
        for item in session.result_of(scene).sources
    ]


def test_a_jump_to_a_frame_that_was_played_brings_back_its_slide(scene, crate):
    add_texture(scene, sliding=0.2, full_force=0.1, full_speed=0.01, noise=0.4)
    scene.haptics.impacts = False
    played = {}
    for frame in range(1, 31):
        scene.frame_set(frame)
        played[frame] = slides(scene)
    for frame in (7, 25, 12, 30):
        scene.frame_set(frame)
        assert slides(scene) == played[frame] and len(played[frame]) == 2


def test_edits_of_a_paused_frame_compare_on_the_same_slide(scene, crate):
    add_texture(
        scene, first_kind="MATERIAL", first="Softwood", sliding=0.2, full_force=0.1, full_speed=0.01
    )
    play(scene, 30)
    scene.frame_set(12)
    slide = slides(scene)
    assert len(slide) == 2
    scene.haptics.mode = "SD"
    crate.haptics.rho = 0.3
    scene.frame_set(12)
    assert slides(scene) == slide
    row = scene.haptics.textures.items[0]
    row.sliding = 0.4
    scene.frame_set(12)
    assert slides(scene)[-1][2] == pytest.approx(0.4)
    assert bpy.ops.haptic.add_textures() == {"FINISHED"}
    scene.frame_set(12)
    assert len(slides(scene)) == 2
    crate.haptics.material.name = "Steel"
    scene.frame_set(12)
    assert slides(scene)[-1][2] != pytest.approx(0.4)  # the row of concrete counts
    crate.location.z += 1.0
    crate.keyframe_insert("location", frame=12)
    scene.frame_set(12)
    assert slides(scene) == []


@pytest.mark.slow
def test_the_core_plays_the_exported_file_as_blender_plays_the_scene(scene, crate, tmp_path):
    add_texture(scene, period=0.007, noise=0.4)
    exported(tmp_path / "crate.json", frames="RANGE", frame_start=1, frame_end=LAST)
    export = read_export(tmp_path / "crate.json")
    again = traced(export.scene, export.recording)
    for ours, theirs in zip(play(scene, LAST + 1), again, strict=True):
        assert ours.number == theirs.number
        if ours.number > 1:
            np.testing.assert_allclose(theirs.block, ours.block, rtol=0, atol=1e-12)
            if ours.number in range(10, 60):
                assert theirs.block.any()
