import re
from pathlib import Path

SCENARIOS = Path(__file__).parent / "scenarios"
TROUBLE = re.compile(r"Traceback|Error|Exception|Warning: |rna_ui|uiItem")


def trouble(printed: str) -> list[str]:
    """The lines of Blender's console that speak of something wrong."""
    return [line for line in printed.splitlines() if TROUBLE.search(line)]


def played_through(played: tuple[dict, str], told: str = "") -> dict[str, object]:
    """What a scenario saw, once it came to its end with nothing wrong on the console and nothing
    left behind. ``told``: part of a warning that it asks for."""
    report, printed = played
    assert report["error"] is None, report["error"]
    assert [line for line in trouble(printed) if not told or told not in line] == []
    seen = report["seen"]
    assert seen.pop("left after disabling") == {}
    return seen


def test_installs_from_the_zip(installed):
    assert 'Installed "haptic_tracing"' in installed
    assert trouble(installed) == []


def test_sidebar(play):
    seen = played_through(play(SCENARIOS / "sidebar.py"))
    assert all(seen.values()), seen


def test_height_of_the_sidebar(play):
    seen = played_through(play(SCENARIOS / "sidebar_height.py"))
    assert all(seen.values()), seen


def test_ten_situations_show_few_buttons(play):
    seen = played_through(play(SCENARIOS / "situations.py"))
    assert all(seen.values()), seen


def test_a_clip_for_a_pad_in_thirteen_clicks(play):
    seen = played_through(play(SCENARIOS / "clip.py"))
    assert all(seen.values()), seen


def test_inspection_and_table(play):
    seen = played_through(play(SCENARIOS / "inspection.py"))
    assert all(seen.values()), seen


def test_themes_scale_and_language(play):
    seen = played_through(play(SCENARIOS / "languages.py"))
    assert all(seen.values()), seen


def test_quick_start(play):
    seen = played_through(play(SCENARIOS / "quick_start.py"))
    assert all(seen.values()), seen


def test_bodies(play):
    seen = played_through(play(SCENARIOS / "bodies.py"))
    assert all(seen.values()), seen


def test_sound_to_vibration(play):
    seen = played_through(play(SCENARIOS / "sound.py"))
    assert all(seen.values()), seen


def test_surfaces(play):
    seen = played_through(play(SCENARIOS / "surfaces.py"))
    assert all(seen.values()), seen


def test_unit_scale(play):
    seen = played_through(play(SCENARIOS / "unit_scale.py"))
    assert all(seen.values()), seen


def test_authoring(play):
    seen = played_through(play(SCENARIOS / "authoring.py"))
    assert all(seen.values()), seen


def test_files_scenes_and_workspaces(play):
    seen = played_through(play(SCENARIOS / "files.py"))
    assert seen.pop("frame handlers") == 1
    assert all(seen.values()), seen


def test_drawn_signals(play):
    seen = played_through(play(SCENARIOS / "drawing.py"))
    assert all(seen.values()), seen


def test_many_objects(play):
    seen = played_through(play(SCENARIOS / "many_objects.py"))
    assert all(seen.values()), seen


def test_demo(play):
    seen = played_through(play(SCENARIOS / "demo.py"))
    assert all(seen.values()), seen


def test_bake_and_meters(play):
    seen = played_through(play(SCENARIOS / "bake.py"))
    assert all(seen.values()), seen


def test_modes_and_meters(play):
    seen = played_through(play(SCENARIOS / "modes.py"))
    assert all(seen.values()), seen


def test_live_output(play):
    seen = played_through(play(SCENARIOS / "live_output.py"))
    assert all(seen.values()), seen


def test_files_out_and_in(play):
    seen = played_through(play(SCENARIOS / "formats.py"), "exported from a .blend: open that here")
    assert all(seen.values()), seen


def test_library_overrides(play):
    seen = played_through(play(SCENARIOS / "overrides.py"))
    assert all(seen.values()), seen


def test_answer_hint_path_and_corners(play):
    seen = played_through(play(SCENARIOS / "answer.py"))
    assert all(seen.values()), seen


def test_looking_does_not_change_what_is_felt(play):
    seen = played_through(play(SCENARIOS / "same_blow.py"))
    assert all(seen.values()), seen


def test_heavy_colliders(play):
    seen = played_through(play(SCENARIOS / "heavy.py"))
    assert all(seen.values()), seen


def test_tutorial(play):
    seen = played_through(play(SCENARIOS / "tutorial.py"))
    assert all(seen.values()), seen


def test_samples(play):
    seen = played_through(play(SCENARIOS / "samples.py"))
    assert all(seen.values()), seen


def test_solo_and_mute(play):
    seen = played_through(play(SCENARIOS / "solo.py"))
    assert all(seen.values()), seen


def test_timeline_of_touch(play):
    seen = played_through(play(SCENARIOS / "timeline.py"))
    assert all(seen.values()), seen


def test_adjusting_the_last_operation(play):
    seen = played_through(play(SCENARIOS / "adjust.py"))
    assert all(seen.values()), seen


def test_gizmos(play):
    seen = played_through(play(SCENARIOS / "gizmos.py"))
    assert all(seen.values()), seen


def test_newcomers_mends(play):
    seen = played_through(play(SCENARIOS / "mends.py"))
    assert all(seen.values()), seen


def test_menus_with_pictures(play):
    seen = played_through(play(SCENARIOS / "menus.py"))
    assert all(seen.values()), seen


def test_one_shots(play):
    seen = played_through(play(SCENARIOS / "one_shots.py"))
    assert all(seen.values()), seen


def test_rules_of_impacts(play):
    seen = played_through(play(SCENARIOS / "rules.py"))
    assert all(seen.values()), seen


def test_who_is_felt_among_twenty(play):
    seen = played_through(play(SCENARIOS / "felt.py"))
    assert all(seen.values()), seen


def test_sliding_and_rolling(play):
    seen = played_through(play(SCENARIOS / "textures.py"))
    assert all(seen.values()), seen


def test_pictures_in_panels(play):
    seen = played_through(play(SCENARIOS / "pictures.py"))
    assert all(seen.values()), seen


def test_lane(play):
    seen = played_through(play(SCENARIOS / "lane.py"))
    assert all(seen.values()), seen


def test_clicks(play):
    seen = played_through(play(SCENARIOS / "clicks.py"))
    assert all(seen.values()), seen


def test_view_layers(play):
    seen = played_through(play(SCENARIOS / "view_layers.py"))
    assert all(seen.values()), seen
