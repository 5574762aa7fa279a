"""Looking does not change what is felt: a frame keeps its impacts until something that makes
impacts changes."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest
from haptic_tracing.addon.session import session

_PLACE = Path(__file__).parents[2] / "docs" / "pictures" / "tutorial" / "hammer_nail_by_hand.py"
_specification = importlib.util.spec_from_file_location("hammer_nail_by_hand", _PLACE)
tutorial = importlib.util.module_from_spec(_specification)
_specification.loader.exec_module(tutorial)
FRAME = 22
"""The hammer strikes at frame 20."""


@pytest.fixture(scope="module")
def tutorial_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Where the tutorial's scene is stored once it was made."""
    return tmp_path_factory.mktemp("tutorial") / "hammer_nail.blend"


@pytest.fixture
def struck(tutorial_file: Path) -> Any:
    """The tutorial's scene, stepped through to frame 22."""
    if not tutorial_file.exists():
        bpy.ops.wm.read_homefile(use_factory_startup=True)
        for step in tutorial.STEPS:
            step()
        bpy.ops.wm.save_as_mainfile(filepath=str(tutorial_file), compress=False)
    bpy.ops.wm.open_mainfile(filepath=str(tutorial_file))
    return stepped(bpy.context.scene, 1, FRAME)


def stepped(scene: Any, first: int, last: int) -> Any:
    for frame in range(first, last + 1):
        scene.frame_set(frame)
    return scene


def impacts(scene: Any) -> list[tuple[str, float, float]]:
    """Name, onset and amplitude of the impacts that sound in the frame shown."""
    return [(item.name, item.onset, item.amplitude) for item in session.result_of(scene).sources]


def choose_mode(mode: str) -> None:
    bpy.ops.wm.context_set_enum(data_path="scene.haptics.mode", value=mode)


def test_each_mode_renders_the_same_blow(struck):
    blow, felt = impacts(struck), session.result_of(struck).amplitudes.copy()
    assert len(blow) == 1
    for mode in ("SD", "MD", "MN", "HT"):
        choose_mode(mode)
        assert impacts(struck) == blow, mode
    assert session.result_of(struck).amplitudes == pytest.approx(felt, rel=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize(
    "look",
    [
        lambda scene: setattr(scene.haptics, "show_flow", True),
        lambda scene: setattr(scene.objects["Hand"].haptics.listener, "gain", 0.5),
        lambda scene: setattr(scene.objects["Hammer"].haptics, "rho", 0.2),
        lambda scene: setattr(scene.haptics, "strategy", "as_in_the_paper"),
        lambda scene: scene.objects["Hand"].haptics.keyframe_insert("rho", frame=FRAME),
        lambda scene: scene.objects["Table"].select_set(True),
        lambda scene: bpy.ops.haptic.trace_frame(),
        lambda scene: scene.frame_set(FRAME),
        lambda scene: (scene.frame_set(5), scene.frame_set(FRAME)),
    ],
)
def test_edits_that_do_not_affect_impacts_keep_them(struck, look):
    blow = impacts(struck)
    look(struck)
    bpy.context.view_layer.update()
    assert impacts(struck) == blow


def test_a_material_changes_what_the_same_blow_feels_like(struck):
    (before,) = session.result_of(struck).sources
    struck.objects["Nail"].haptics.material.name = struck.objects[
        "Hammer"
    ].haptics.material.name = "Rubber"
    bpy.context.view_layer.update()
    (after,) = session.result_of(struck).sources
    assert (after.onset, after.amplitude) == (before.onset, before.amplitude)
    assert after.signal != before.signal


def test_switching_impacts_off_and_on_brings_them_back(struck):
    blow = impacts(struck)
    struck.haptics.impacts = False
    bpy.context.view_layer.update()
    assert impacts(struck) == []
    struck.haptics.impacts = True
    bpy.context.view_layer.update()
    assert impacts(struck) == blow


def _key_elsewhere(scene: Any) -> None:
    """Another swing, which is the same at frame 22."""
    wrist = scene.objects["Wrist"]
    wrist.rotation_euler.y = -1.0
    wrist.keyframe_insert("rotation_euler", index=1, frame=10)
    wrist.rotation_euler.y = 0.0


@pytest.mark.slow
@pytest.mark.parametrize(
    "change",
    [
        lambda scene: setattr(scene.haptics, "minimum_energy", 1.0),
        lambda scene: setattr(scene.objects["Hammer"].rigid_body, "mass", 3.0),
        lambda scene: setattr(scene.objects["Nail"].rigid_body, "restitution", 0.9),
        lambda scene: setattr(scene.objects["Nail"].location, "x", 0.31),
        lambda scene: setattr(scene.objects["Nail"].scale, "z", 1.1),
        lambda scene: bpy.data.objects.remove(scene.objects["Table"]),
        lambda scene: setattr(scene.render, "fps", 30),
        _key_elsewhere,
    ],
)
def test_edits_that_affect_impacts_drop_them(struck, change):
    change(struck)
    bpy.context.view_layer.update()
    struck.frame_set(FRAME)
    assert impacts(struck) == []


@pytest.mark.slow
def test_playing_on_and_playing_anew_give_what_they_gave_without_looking(struck):
    def rendered(first: int, last: int) -> list[Any]:
        blocks = []
        for frame in range(first, last + 1):
            struck.frame_set(frame)
            blocks.append(session.result_of(struck).block)
        return blocks

    untouched = [block for block in rendered(1, 40) if block is not None]
    stepped(struck, 1, 19)
    choose_mode("SD")  # just before the strike, and back again
    choose_mode("HT")
    on = rendered(20, 40)
    assert np.abs(np.concatenate(on, axis=1)).max() > 0
    assert all(np.array_equal(a, b) for a, b in zip(on, untouched[-21:], strict=True))
    anew = [block for block in rendered(1, 40) if block is not None]
    assert all(np.array_equal(a, b) for a, b in zip(anew, untouched, strict=True))


def test_a_bake_begins_without_the_impacts_of_before(struck):
    from haptic_tracing.addon.session import timeline

    (result,) = timeline.results(struck, FRAME, FRAME)
    assert result.sources == ()


def reopened(path: Path) -> Any:
    """The file's scene as a window shows it once it is loaded."""
    from haptic_tracing.addon.registration import handlers

    bpy.ops.wm.open_mainfile(filepath=str(path))
    handlers.trace_opened()
    return bpy.context.scene


def test_a_saved_file_opens_with_its_result(struck, tmp_path):
    before = session.result_of(struck)
    blow, path = impacts(struck), tmp_path / "struck.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    scene = reopened(path)
    after = session.result_of(scene)
    assert after.number == FRAME
    assert impacts(scene) == blow
    assert after.impacts == before.impacts
    assert after.amplitudes == pytest.approx(before.amplitudes, rel=1e-6)
    assert [item.position for item in after.sources] == [
        pytest.approx(item.position, abs=1e-6) for item in before.sources
    ]
    choose_mode("SD")
    assert impacts(scene) == blow


def test_what_was_changed_elsewhere_keeps_no_impacts(struck, tmp_path):
    path = tmp_path / "struck.blend"
    kept = struck.haptics
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    text = kept.kept_impacts
    for spoiled in (
        text.replace('"frame":22', '"frame":23'),
        text.replace("Nail", "Anvil"),
        text.replace('"motion":"', '"motion":"0'),
        text[:-1],
        text.replace('"energy":', '"energy":-'),
        '{"frame":22}',
        "x" * 2**17,
    ):
        assert spoiled != text
        scene = reopened(path)
        scene.haptics.kept_impacts = spoiled
        session.clear()
        scene.frame_set(FRAME)
        assert impacts(scene) == []


def test_a_baked_file_has_its_impacts_in_every_frame(struck, tmp_path):
    bpy.ops.haptic.bake()
    struck.frame_set(FRAME)
    blow, path = impacts(struck), tmp_path / "baked.blend"
    felt = session.result_of(struck).amplitudes
    struck.frame_set(5)
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    assert len(blow) == 1
    scene = reopened(path)
    assert scene.frame_current == 5 and impacts(scene) == []
    for frame, expected in ((FRAME, blow), (19, []), (FRAME + 1, blow), (FRAME, blow)):
        scene.frame_set(frame)
        assert impacts(scene) == expected, frame
    assert session.result_of(scene).amplitudes == pytest.approx(felt, rel=1e-6)
    assert session.result_of(scene).path_objects(0, 0)


def test_baked_impacts_of_another_motion_are_not_shown(struck, tmp_path):
    bpy.ops.haptic.bake()
    struck.frame_set(5)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "baked.blend"))
    scene = reopened(tmp_path / "baked.blend")
    _key_elsewhere(scene)
    scene.frame_set(FRAME)
    assert impacts(scene) == []


def test_a_frame_without_impacts_is_saved_without(struck, tmp_path):
    struck.frame_set(5)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "before.blend"))
    assert struck.haptics.kept_impacts == ""
    assert impacts(reopened(tmp_path / "before.blend")) == []


def test_frames_are_traced_in_edit_mode(struck):
    bpy.context.view_layer.objects.active = struck.objects["Table"]
    bpy.ops.object.mode_set(mode="EDIT")
    struck.haptics.tracing = True  # what an author sets has changed: what makes impacts is compared
    for frame in range(1, FRAME + 1):
        struck.frame_set(frame)
        assert session.result_of(struck).number == frame
    assert len(impacts(struck)) == 1
    bpy.ops.object.mode_set(mode="OBJECT")
    bpy.context.view_layer.update()
    assert len(impacts(struck)) == 1
