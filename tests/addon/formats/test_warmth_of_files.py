"""Warmth into files and back: the core feels from the file what Blender shows."""

import bpy
import numpy as np
import pytest
from haptic_tracing.core.formats.haptic_scene import read_export
from scene_files import exported, imported


def shown():
    """What the panel shows, by listener."""
    from haptic_tracing.addon.session import session, sessions

    scene = bpy.context.scene
    session.trace(scene, bpy.context.evaluated_depsgraph_get())
    (felt,) = sessions.felt_in(scene)
    return dict(zip(felt.listeners, felt.values.tolist(), strict=True))


def from_file(path):
    """What the core alone feels."""
    export = read_export(path)
    (thermal,) = export.modalities
    felt = thermal.felt_in(export.scene)
    return dict(zip(felt.listeners, felt.values.tolist(), strict=True))


@pytest.fixture
def hearth(add_box, add_empty):
    """A stone hearth and a wooden bench on it, a fire that stands apart as an empty, a hand."""
    scene = bpy.context.scene
    scene.haptics.modalities.thermal.enabled = True
    stone, wood = (
        add_box("stone", (0, 0, -0.15), (4, 1, 0.3)),
        add_box("wood", (1, 0, 0.2), (1.3, 0.5, 0.4)),
    )
    stone.haptics.modalities.thermal.conductivity, stone.haptics.modalities.thermal.thickness = (
        2.8,
        0.3,
    )
    wood.haptics.modalities.thermal.function, wood.haptics.modalities.thermal.alpha = (
        "exponential",
        0.7,
    )
    fire = add_empty("fire", (-0.71, 0.13, 0.15), parent=stone)
    fire.haptics.modalities.thermal.is_source, fire.haptics.modalities.thermal.source_value = (
        True,
        321.7,
    )
    wood.haptics.modalities.thermal.is_source, wood.haptics.modalities.thermal.source_value = (
        True,
        3.3,
    )
    hand = add_empty("hand", (0.1, 0.05, 0.5), parent=wood)
    hand.haptics.listener.enabled = True
    bpy.context.view_layer.update()
    return scene


def test_blender_and_core_feel_the_same(hearth, tmp_path):
    first = exported(tmp_path / "a.json")
    before, core = shown(), from_file(tmp_path / "a.json")
    assert before.keys() == core.keys() == {"hand"} and before["hand"] > 1
    assert core["hand"] == pytest.approx(before["hand"], rel=1e-12)
    imported(tmp_path / "a.json")
    assert bpy.data.objects["fire"].haptics.modalities.thermal.source_value == pytest.approx(321.7)
    assert (
        bpy.data.objects["fire"].parent.name == "stone"
        and not bpy.data.objects["fire"].haptics.source.enabled
    )
    assert shown()["hand"] == pytest.approx(core["hand"], rel=1e-12)
    assert exported(tmp_path / "b.json") == first


@pytest.mark.slow
def test_the_sample_with_a_fireplace(tmp_path):
    from haptic_tracing.sample_scenes import fireplace

    fireplace.build(bpy.context.scene)
    bpy.context.scene.frame_set(3)
    first = exported(tmp_path / "a.json")
    before, core = shown(), from_file(tmp_path / "a.json")
    assert before.keys() == core.keys() and max(before.values()) > 5
    np.testing.assert_allclose([core[name] for name in before], list(before.values()), rtol=1e-12)
    imported(tmp_path / "a.json")
    bpy.context.scene.frame_set(3)  # an import leaves the current frame as it was
    after = shown()
    np.testing.assert_allclose([after[name] for name in before], list(before.values()), rtol=1e-12)
    assert exported(tmp_path / "b.json") == first


def test_numbers_keep_their_digits(hearth, tmp_path):
    exported(tmp_path / "a.json")
    text = (tmp_path / "a.json").read_text()
    for short, long in (
        (":2.8", ":2.80000000012345"),
        (":321.7", ":321.700000000123"),
        ("0.7}", "0.70000000000123}"),
    ):
        assert short in text
        text = text.replace(short, long)
    (tmp_path / "a.json").write_text(text)
    imported(tmp_path / "a.json")
    assert shown()["hand"] == pytest.approx(from_file(tmp_path / "a.json")["hand"], rel=1e-12)
    exported(tmp_path / "b.json")
    assert (
        read_export(tmp_path / "b.json").modalities == read_export(tmp_path / "a.json").modalities
    )


def test_a_range_says_that_warmth_is_that_of_its_first_frame(hearth, tmp_path, capfd):
    exported(tmp_path / "a.json", frames="RANGE", frame_start=1, frame_end=2)
    assert "Not in this file: how warmth changes over time" in capfd.readouterr().out
    exported(tmp_path / "b.json")
    assert "Not in" not in capfd.readouterr().out


def test_switched_off_and_ranges(hearth, tmp_path):
    hearth.haptics.modalities.thermal.enabled = False
    exported(tmp_path / "a.json", frames="RANGE", frame_start=1, frame_end=3)
    (thermal,) = read_export(tmp_path / "a.json").modalities
    assert not thermal.enabled and [emitter.name for emitter in thermal.emitters] == [
        "fire",
        "wood",
    ]
    imported(tmp_path / "a.json")
    assert not bpy.context.scene.haptics.modalities.thermal.enabled
    assert bpy.data.objects["stone"].haptics.modalities.thermal.conductivity == pytest.approx(2.8)


def test_a_scene_without_warmth_has_no_section(add_box, tmp_path):
    add_box("box", (0, 0, 0), (1, 1, 1))
    exported(tmp_path / "a.json")
    assert read_export(tmp_path / "a.json").modalities == ()
