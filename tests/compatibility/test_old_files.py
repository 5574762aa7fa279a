"""Files and commands of earlier versions give the levels that they gave, or `meant.json` says what
changed and why: see README.md."""

import math
import sys
from pathlib import Path

import bpy
import haptic_tracing
import pytest

sys.path.insert(0, str(Path(__file__).parent))

import compare
import levels

STORED, MEANT = compare.stored(), compare.meant()
IS_NEW_ENOUGH = bpy.app.version >= (5, 0, 0)
"""Whether this Blender opens files of Blender 5."""


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """The folder of the files; the add-on is enabled."""
    folder = tmp_path_factory.mktemp("old files")
    compare.unpack(folder)
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    haptic_tracing.register()
    yield folder
    haptic_tracing.unregister()


def each(name):
    """The parameter of a name, marked slow unless it is typical; left out where Blender is older
    than the file."""
    is_of_blender_5 = "samples/" in name or name == "blends/00 every material"
    marks = [
        pytest.mark.skipif(is_of_blender_5 and not IS_NEW_ENOUGH, reason="a file of Blender 5")
    ]
    if not name.startswith(compare.TYPICAL):
        marks.append(pytest.mark.slow)
    return pytest.param(name, marks=marks, id=name)


@pytest.mark.parametrize("name", [each(name) for name in STORED])
def test_old_files_and_commands_give_the_old_levels(files, name, record_property):
    equal, decibels, place = compare.outcome(name, files, STORED[name])
    record_property("old file", [name, equal, decibels])
    limit = MEANT[name]["decibels"] if name in MEANT else 0.0
    assert decibels <= limit + levels.TOLERANCE, place


@pytest.mark.slow
def test_settings_bring_the_old_levels_back(files, tmp_path):
    for name, change in MEANT.items():
        if change["restore"]:
            found = compare.measure(
                name,
                STORED[name]["frames"],
                files,
                tmp_path / name.replace("/", " "),
                change["restore"],
            )
            decibels, place = levels.difference(STORED[name]["measured"], found)
            assert decibels <= levels.TOLERANCE, place


def test_changes_that_are_meant_are_of_stored_files_and_give_a_reason():
    assert MEANT.keys() <= STORED.keys()
    assert all(
        change["reason"] and 0 < change["decibels"] < math.inf and "restore" in change
        for change in MEANT.values()
    )


def test_differences_are_found_in_levels_names_and_impacts():
    before = {
        "levels": {"1": [-20.0, None]},
        "impacts": [[3, "a", "b", 0.1, 2.0]],
        "names": ["a"],
        "bits": "1",
    }
    assert levels.difference(before, {**before, "bits": "2"})[0] == 0.0
    assert levels.difference(before, {**before, "levels": {"1": [-20.25, None]}}) == (
        0.25,
        "/levels/1/0",
    )
    assert levels.difference(before, {**before, "levels": {"1": [-20.0, -99.5]}})[0] == 0.5
    assert levels.difference(before, {**before, "impacts": [[3, "a", "b", 0.1, 4.0]]})[
        0
    ] == pytest.approx(3.01, abs=0.01)
    for change in (
        {"impacts": []},
        {"impacts": [[3, "a", "c", 0.1, 2.0]]},
        {"names": ["b"]},
        {"levels": {}},
    ):
        assert levels.difference(before, {**before, **change})[0] == math.inf
