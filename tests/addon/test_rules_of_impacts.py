"""The table of rules of impacts in Blender: what it says is played, what is wrong with a row is
said beside it, and the rest goes on."""

import wave

import bpy
import numpy as np
import pytest
from haptic_tracing.addon.io import drawings
from haptic_tracing.addon.session import session, sessions
from haptic_tracing.core.scene.impact_rule import ImpactRule
from haptic_tracing.core.scene.rule_table import Side
from haptic_tracing.core.signals import Automation, Drawing, impact_template
from written_scenes import read_scene


def write_wav(path, samples, rate=8000):
    with wave.open(str(path), "wb") as file:
        file.setnchannels(1)
        file.setsampwidth(2)
        file.setframerate(rate)
        file.writeframes((np.asarray(samples) * 32767).astype("<i2").tobytes())
    return str(path)


def write_float_wav(path, samples):
    """With IEEE floats, which may be no numbers."""
    data = np.asarray(samples, dtype="<f4").tobytes()
    form = (
        np.array([3, 1], "<u2").tobytes()
        + np.array([8000, 32000], "<u4").tobytes()
        + np.array([4, 32], "<u2").tobytes()
    )
    body = (
        b"WAVE"
        + b"fmt "
        + np.uint32(16).tobytes()
        + form
        + b"data"
        + np.uint32(len(data)).tobytes()
        + data
    )
    path.write_bytes(b"RIFF" + np.uint32(len(body)).tobytes() + body)
    return str(path)


@pytest.fixture
def crate(scene, add_box, add_empty):
    """A wooden crate that falls on stone; a listener on the ground."""
    bpy.ops.rigidbody.world_add()
    ground = add_box("ground", (0, 0, -0.5), (10, 10, 1), "PASSIVE")
    crate = add_box("crate", (0, 0, 0.95), (0.5, 0.5, 0.5), "ACTIVE", mass=12.0)
    ground.haptics.material.name, crate.haptics.material.name = "Stone", "Softwood"
    add_empty("skin", (0.1, 0, 0.0), ground).haptics.listener.enabled = True
    return crate


@pytest.fixture
def blow(scene, crate):
    """The signal and amplitude of the crate's first impact, None where there is none; and the
    problems of rows."""

    def play():
        for frame in range(1, 16):
            scene.frame_set(frame)
            sources = session.result_of(scene).sources
            if sources:
                return sources[0]
        return None

    return play


def add_rule(scene, **properties):
    row = scene.haptics.impact_table.items.add()
    for name, value in properties.items():
        setattr(row, name, value)
    return row


def problems(scene):
    return {problem.rule: problem.message for problem in sessions.shown_problems(scene)}


def test_the_row_of_the_pair_is_played(scene, blow, tmp_path):
    ring = np.exp(-np.arange(4000) / 400) * np.sin(np.arange(4000))
    path = write_wav(tmp_path / "ring.wav", ring, rate=16_000)
    add_rule(scene, template="PLAIN")
    add_rule(
        scene,
        first_kind="MATERIAL",
        first="Soft*",
        second_kind="OBJECT",
        second="ground",
        template="FILE",
        filepath=path,
    )
    source = blow()
    assert source.signal.duration == pytest.approx(0.25)
    np.testing.assert_allclose(
        source.signal.sample(0, 2000, 16_000.0), ring[:2000], rtol=0, atol=1e-3
    )
    assert problems(scene) == {}


def test_a_drawn_signal_is_played_once_in_frames_after_its_edit_too(scene, blow):
    tree = drawings.drawn(
        "click",
        Drawing(
            Automation((0.0, 0.1), (1.0, 0.0)), Automation((0.0,), (200.0,)), 0.1, loops=True
        ).to_signal(),
    )
    rule = add_rule(scene, template="DRAWN")
    assert blow().signal == impact_template("stone", "wood")
    (message,) = problems(scene).values()
    assert message.startswith("no signal is drawn yet")
    rule.drawing = tree
    scene.frame_set(1)
    times = np.arange(800) / 8000
    np.testing.assert_allclose(
        blow().signal.sample(0, 800, 8000.0),
        (1 - 10 * times) * np.sin(400 * np.pi * times),
        rtol=0,
        atol=1e-5,
    )
    assert problems(scene) == {}
    assert tree in {item.original for item in bpy.context.evaluated_depsgraph_get().ids}, (
        "editing its curves traces again"
    )


def test_its_own_full_energy_counts_for_the_pair(scene, blow):
    by_scene = blow().amplitude
    scene.frame_set(1)
    add_rule(scene, first_kind="OBJECT", first="crate", full_energy=1e4)
    assert blow().amplitude < by_scene / 2


def test_without_rows_impacts_are_those_of_the_scene(scene, blow):
    assert blow().signal == impact_template("stone", "wood")


BAD = {
    "silent": (lambda folder: write_wav(folder / "a.wav", np.zeros(800)), "no vibration"),
    "longer than a minute": (
        lambda folder: write_wav(folder / "a.wav", np.full(8000 * 61, 0.5)),
        "a.wav lasts longer than a minute",
    ),
    "missing": (lambda folder: str(folder / "gone.wav"), "there is no file"),
    "elsewhere": (
        lambda folder: "\\\\server\\share\\a.wav",
        "is on another computer: allow online access",
    ),
    "not finite": (
        lambda folder: write_float_wav(folder / "a.wav", [0.5, np.nan, 0.1] * 100),
        "not finite",
    ),
    "no sound file": (
        lambda folder: (folder / "a.wav").write_text("hello") and str(folder / "a.wav"),
        "a.wav",
    ),
    "another ending": (
        lambda folder: (folder / "a.txt").write_text("hello") and str(folder / "a.txt"),
        "the ending must be one of",
    ),
    "none chosen": (lambda folder: "", "none is chosen"),
}


@pytest.mark.parametrize("name", BAD)
def test_a_bad_file_is_said_beside_its_row_and_the_rest_goes_on(scene, blow, tmp_path, name):
    write, words = BAD[name]
    add_rule(scene, first_kind="OBJECT", first="nail*", template="PLAIN")
    add_rule(scene, first_kind="OBJECT", first="crate", template="FILE", filepath=write(tmp_path))
    source = blow()
    assert source.signal == impact_template("stone", "wood")
    assert words in problems(scene)["impact_table", 1]


def test_rules_follow_the_objects_that_they_name(scene, crate, add_box, traced):
    """A rename is followed, also where another object gets the name; what is chosen afterwards
    is meant by its name of then."""
    rules = [
        add_rule(scene, first_kind="OBJECT", first="crate", second_kind="OBJECT", second="ground"),
        scene.haptics.textures.items.add(),
        add_rule(scene, first_kind="OBJECT", first="cr*"),
        add_rule(scene, first_kind="MATERIAL", first="crate"),
    ]
    rules[1].second_kind, rules[1].second = "OBJECT", "crate"
    traced()
    crate.name = "Kiste \u00e4\u6728"
    add_box("crate", (3, 0, 0.25), (0.5, 0.5, 0.5))
    bpy.context.view_layer.update()
    assert [rules[0].first, rules[0].second, rules[1].second] == [crate.name, "ground", crate.name]
    assert [rules[2].first, rules[3].first] == ["cr*", "crate"]
    rules[0].first = "crate"
    bpy.context.view_layer.update()
    assert rules[0].first == "crate"
    bpy.data.objects.remove(bpy.data.objects["crate"])
    bpy.context.view_layer.update()
    traced()
    assert problems(scene)["impact_table", 0] == "there is no haptic object 'crate'"


@pytest.mark.parametrize(
    ("side", "words"),
    [(("OBJECT", "anvil"), "there is no haptic object 'anvil'"), (("MATERIAL", "Cheese"), "nothing is made of a material 'Cheese'"),
     (("OBJECT", ""), "choose what this rule is for")],
)  # fmt: skip
def test_a_row_for_what_is_not_there_is_said_and_does_nothing(scene, blow, side, words):
    add_rule(scene, first_kind=side[0], first=side[1], template="PLAIN")
    assert blow().signal == impact_template("stone", "wood")
    assert words in problems(scene)["impact_table", 0]


def test_buttons_edit_the_table(scene, crate):
    bpy.context.view_layer.objects.active = crate
    table = scene.haptics.impact_table
    for _ in range(2):
        assert bpy.ops.haptic.add_rule(table="impact_table") == {"FINISHED"}
    assert [(row.first_kind, row.first, row.second_kind) for row in table.items] == [
        ("MATERIAL", "Softwood", "ANY")
    ] * 2
    table.items[1].template = "PLAIN"
    assert bpy.ops.haptic.remove_rule(table="impact_table") == {"FINISHED"}
    assert [row.template for row in table.items] == ["MATERIALS"] and table.active == 0


def test_variations_depend_on_the_blow_alone_whatever_is_played(scene, blow):
    """From the first frame on, or from a later one: the same bits."""
    add_rule(scene, variation=0.3)
    first = blow()
    scene.frame_set(4)
    again = blow()
    assert (again.signal, again.amplitude) == (first.signal, first.amplitude)


def test_the_table_is_written_to_files(scene, crate, tmp_path):
    add_rule(
        scene,
        first_kind="OBJECT",
        first="crate",
        second_kind="MATERIAL",
        second="Stone*",
        full_energy=70.5,
    )
    values = {"gain": (0.25, 0.75), "brightness": (0.1, 0.9)}
    add_rule(scene, template="PLAIN", variation=0.2, **values)
    assert bpy.ops.export_scene.haptic_scene(filepath=str(tmp_path / "a.json")) == {"FINISHED"}
    written = read_scene(tmp_path / "a.json")
    first, second = written.rules.impact_table.rows
    assert first.between == (Side(object="crate"), Side(material="Stone*"))
    assert first.value.limits.full_energy == 70.5 and second.value.limits is None
    assert second.value == ImpactRule("plain", variation=0.2, **values)
    assert {item.name: item.material for item in written.objects} == {
        "crate": "Softwood",
        "ground": "Stone",
    }
