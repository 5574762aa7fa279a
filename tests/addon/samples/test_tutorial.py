"""The steps of the tutorial give what its text says."""

import importlib.util
import re
from pathlib import Path

import bpy
import numpy as np
import pytest
from haptic_tracing.addon.session import session, sessions
from haptic_tracing.addon.view.levels import shown_levels

DOCS = Path(__file__).parents[3] / "docs"
_specification = importlib.util.spec_from_file_location(
    "hammer_nail_by_hand", DOCS / "pictures" / "tutorial" / "hammer_nail_by_hand.py"
)
tutorial = importlib.util.module_from_spec(_specification)
_specification.loader.exec_module(tutorial)


@pytest.fixture
def by_hand():
    """The scene at its end, in the file that Blender starts with."""
    bpy.ops.wm.read_homefile(use_factory_startup=True)
    for step in tutorial.STEPS:
        step()
    return bpy.context.scene


def test_the_blow_is_felt_in_the_hand_as_the_text_says(by_hand):
    found = []
    for frame in range(1, tutorial.LIFTED + 1):
        by_hand.frame_set(frame)
        result = session.result_of(by_hand)
        assert session.problems_of(by_hand) == ()
        if result.impacts:
            found.append(result)
    (result,) = found
    (impact,) = result.impacts
    text = (DOCS / "tutorial.md").read_text(encoding="utf-8")
    assert (
        result.number == tutorial.STRIKES[0] == int(re.search(r"strikes at frame (\d+)", text)[1])
    )
    assert impact.energy == pytest.approx(
        float(re.search(r"energy of ([\d.]+) joules", text)[1]), abs=0.05
    )
    assert impact.amplitude == pytest.approx(impact.energy / (tutorial.HAMMER_MASS * 9.81 * 0.5))
    by_hand.frame_set(result.number)
    session.result_of(by_hand)
    (level,) = shown_levels(sessions.shown(by_hand), False)
    assert level.margin_text() == re.search(r"(\+\d+ dB) above the threshold", text)[1]
    (gain,) = result.amplitudes[-1]
    path = result.path_objects(len(result.sources) - 1, 0)
    assert path[-2:] == ("Hammer", "Hand")  # the nail passes on as much
    # Steel over 40 cm, then flesh, which is lighter.
    assert gain == pytest.approx(impact.amplitude, rel=1e-3)
    assert gain == pytest.approx(float(re.search(r"= ([\d.]+)\$", text)[1]), abs=5e-4)
    assert 20 * np.log10(gain) == pytest.approx(
        -float(re.search(r"−([\d.]+) dB", text)[1]), abs=0.05
    )


def test_materials_are_guessed_as_the_text_says(by_hand):
    guessed = {
        obj.name: obj.haptics.material.name for obj in by_hand.objects if obj.haptics.enabled
    }
    assert guessed == {"Table": "Hardwood", "Nail": "Steel", "Hammer": "Steel", "Hand": "Flesh"}
    text = (DOCS / "tutorial.md").read_text(encoding="utf-8")
    assert all(name.lower() in text.lower() for pair in guessed.items() for name in pair)


def test_every_picture_is_there():
    text = (DOCS / "tutorial.md").read_text(encoding="utf-8")
    pictures = re.findall(r"!\[[^\]]+\]\(([^)]+)\)", text)
    assert len(pictures) == 5
    assert all((DOCS / picture).is_file() for picture in pictures)
