"""What counts as a contact and as an impact, as a scene file says it."""

import json

import pytest
from haptic_tracing.core.contacts.scene_contacts import contacts_of_scene
from haptic_tracing.core.formats.haptic_scene import read_export, write_export
from haptic_tracing.core.formats.io.error import FormatError
from haptic_tracing.core.formats.scene.recording import traced
from haptic_tracing.core.scene.rules import ContactSettings, ImpactTemplates
from haptic_tracing.core.signals import impact_template

CUBE = {"type": "box", "size": [1, 1, 1]}
FLOOR = {"name": "floor", "kappa": 0.1, "rho": 0.9, "shape": CUBE, "motion": "static"}
DROP = 3.0
"""Metres."""


def scene_file(path, version="1.1", **more):
    """A cube of 2 kg that falls onto another one, every hundredth of a second."""
    height = [max(DROP - 9.81 / 2 * (k / 100) ** 2, 0.0) + 1.0 for k in range(120)]
    cube = {
        "name": "cube",
        "kappa": 0.2,
        "rho": 0.8,
        "shape": CUBE,
        "mass": 2.0,
        "pose": {"position": [0, 0, height[0]]},
    }
    frames = [
        {"frame": k, "poses": {"cube": [0, 0, round(z, 5), 1, 0, 0, 0]}}
        for k, z in enumerate(height)
    ]
    document = {
        "format": "haptic-scene",
        "version": version,
        "objects": [FLOOR, cube],
        "frame_rate": 100,
        "frames": frames,
        **more,
    }
    path.write_text(json.dumps(document))
    return path


def played(path):
    export = read_export(path)
    return list(traced(export.scene, export.recording))


def impacts(path):
    return [impact for result in played(path) for impact in result.impacts]


def test_an_impact_has_the_energy_of_its_fall_by_the_rules_of_the_file(tmp_path):
    energy = 2.0 * 9.81 * DROP
    (impact,) = impacts(scene_file(tmp_path / "a.json", rules={"full_energy": 200.0}))
    assert impact.energy == pytest.approx(energy, rel=0.02) and impact.amplitude == pytest.approx(
        energy / 200, rel=0.02
    )
    assert (
        impacts(
            scene_file(tmp_path / "b.json", rules={"least_energy": 1000.0, "full_energy": 2000.0})
        )
        == []
    )
    assert impacts(scene_file(tmp_path / "c.json", rules={"impacts": False})) == []


def test_impacts_play_the_templates_of_their_materials(tmp_path):
    objects = json.loads(scene_file(tmp_path / "a.json").read_text())["objects"]
    struck = [
        {**item, "impact_material": name}
        for item, name in zip(objects, ("metal", "wood"), strict=True)
    ]
    for templates, known in (("by_material", True), ("plain", False)):
        path = scene_file(tmp_path / "a.json", objects=struck, rules={"templates": templates})
        (signal,) = {source.signal for result in played(path) for source in result.sources}
        assert (signal == impact_template("metal", "wood")) is known


def test_contacts_of_a_scene_at_rest_follow_its_tolerance(tmp_path):
    above = {
        "name": "above",
        "kappa": 0.2,
        "rho": 0.8,
        "shape": CUBE,
        "pose": {"position": [0, 0, 1.03]},
    }
    for tolerance, count in ((0.01, 0), (0.05, 1)):
        scene = read_export(
            scene_file(
                tmp_path / "a.json",
                objects=[FLOOR, above],
                frames=[],
                rules={"tolerance": tolerance},
            )
        ).scene
        assert len(contacts_of_scene(scene)) == count
        assert len(contacts_of_scene(scene, 0.05)) == 1


def test_without_rules_the_defaults_count(tmp_path):
    assert read_export(scene_file(tmp_path / "a.json")).scene.rules == ContactSettings(
        templates=ImpactTemplates.PLAIN
    )


@pytest.mark.parametrize(
    ("rules", "pointer"),
    [({"tolerance": -1}, "/rules/tolerance"), ({"full_energy": 0}, "/rules/full_energy"), ({"energy": "loud"}, "/rules/energy"),
     ({"gravity": [0, 0]}, "/rules/gravity"), ({"impacts": 1}, "/rules/impacts"), ({"triggers": []}, "/rules/triggers")],
)  # fmt: skip
def test_faults_of_rules_name_their_place(tmp_path, rules, pointer):
    with pytest.raises(FormatError) as caught:
        read_export(scene_file(tmp_path / "a.json", rules=rules))
    assert caught.value.pointer == pointer


KNOCK = {"signal": "decaying_sine", "frequency": 99.0, "decay": 0.05, "amplitude": 0.5}
TABLE = [
    {"between": [{"material": "Iron*"}], "limits": {"least_energy": 1000.0}},
    {
        "between": [{"object": "cube"}, {"material": "Wood"}],
        "template": KNOCK,
        "limits": {"least_energy": 0.5, "full_energy": 1000.0},
    },
]


def made_of(path, **materials):
    objects = json.loads(scene_file(path).read_text())["objects"]
    return [{**item, "material": materials[item["name"]]} for item in objects]


def test_an_impact_follows_the_row_of_its_pair(tmp_path):
    energy = 2.0 * 9.81 * DROP
    wood = scene_file(
        tmp_path / "a.json",
        objects=made_of(tmp_path / "a.json", cube="Iron", floor="Wood"),
        rules={"impact_table": TABLE},
    )
    (impact,) = impacts(wood)
    assert impact.amplitude == pytest.approx(energy / 1000, rel=0.02)
    assert {
        source.signal.to_dict() == KNOCK for result in played(wood) for source in result.sources
    } == {True}
    iron = scene_file(
        tmp_path / "b.json",
        objects=made_of(tmp_path / "b.json", cube="Iron", floor="Stone"),
        rules={"impact_table": TABLE},
    )
    assert impacts(iron) == []
    neither = scene_file(
        tmp_path / "c.json",
        objects=made_of(tmp_path / "c.json", cube="", floor="Stone"),
        rules={"impact_table": TABLE},
    )
    # Of full strength is the energy of the cube, the heaviest that moves, after half a metre.
    assert impacts(neither)[0].amplitude == pytest.approx(min(DROP / 0.5, 1), rel=0.02)


def test_tables_are_written_as_they_were_read(tmp_path):
    path = scene_file(
        tmp_path / "a.json",
        objects=made_of(tmp_path / "a.json", cube="Iron", floor="Wood"),
        rules={"impact_table": TABLE},
    )
    export = read_export(path)
    write_export(export, tmp_path / "b.json")
    document = json.loads((tmp_path / "b.json").read_text())
    assert document["rules"]["impact_table"] == [
        {**TABLE[0], "between": [*TABLE[0]["between"], {}]},
        TABLE[1],
    ]
    assert [item.get("material") for item in document["objects"]] == ["Wood", "Iron"]
    assert read_export(tmp_path / "b.json").scene == export.scene


@pytest.mark.parametrize(
    ("row", "pointer"),
    [({"between": [{}, {}, {}]}, "/between"), ({"between": [{"object": "a", "material": "b"}]}, "/between/0"),
     ({"limits": {"full_energy": 0}}, "/limits/full_energy"), ({"template": "loud"}, "/template"),
     ({"template": {"signal": "sine", "frequency": 60}}, "/template"),
     ({"template": {**KNOCK, "decay": -1}}, "/template/decay"), ({"colour": 1}, "/colour")],
)  # fmt: skip
def test_faults_of_rows_name_their_place(tmp_path, row, pointer):
    with pytest.raises(FormatError) as caught:
        read_export(scene_file(tmp_path / "a.json", rules={"impact_table": [{}, row]}))
    assert caught.value.pointer == f"/rules/impact_table/1{pointer}"
