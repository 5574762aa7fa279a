"""The library of haptic materials into files and back; what objects have themselves counts more."""

import json

import bpy
import pytest
from haptic_tracing.addon.authoring import materials
from haptic_tracing.addon.properties.materials import add_material
from haptic_tracing.core.formats.haptic_scene import read_export
from haptic_tracing.core.scene.library import LibraryMaterial
from scene_files import exported, imported


@pytest.fixture
def oak(add_box):
    """Two boxes of oak, of which one has a kappa and a conductivity of its own, and a box of what
    no library knows."""
    scene = bpy.context.scene
    decays = (0.0, 0.01, 0.02, 0.05, 0.1, 0.2)
    values = {
        "kappa": 0.3,
        "rho": 0.7,
        "use_delay": False,
        "wave_speed": 3800.0,
        "use_bands": True,
        "band_decays": decays,
    }
    item = add_material(scene, "oak", values)
    add_material(scene, "nothing is made of it", {"kappa": 0.9})
    boxes = [
        add_box(name, (x, 0, 0), (1, 1, 1))
        for name, x in (("first", 0), ("second", 1), ("third", 5))
    ]
    materials.apply(boxes[:2], item)
    boxes[1].haptics.kappa = 0.45
    boxes[2].haptics.material.name = "ebony"
    boxes[2].haptics.rho = 0.6
    bpy.context.view_layer.update()
    return values


def test_the_library_comes_back_and_objects_keep_what_they_have(oak, tmp_path):
    first = exported(tmp_path / "a.json")
    export = read_export(tmp_path / "a.json")
    assert export.materials == (
        LibraryMaterial("oak", **oak),
        LibraryMaterial("nothing is made of it", 0.9, 0.9),
        LibraryMaterial("ebony", 0.1, 0.6),
    )
    imported(tmp_path / "a.json")
    items = bpy.context.scene.haptics.materials.items
    assert items.keys() == ["oak", "nothing is made of it", "ebony"]
    found = {name: bpy.data.objects[name].haptics for name in ("first", "second", "third")}
    assert [found[name].material.name for name in found] == ["oak", "oak", "ebony"]
    assert [found[name].kappa for name in found] == pytest.approx([0.3, 0.45, 0.1])
    assert exported(tmp_path / "b.json") == first
    items["oak"].kappa = 0.5  # and all that is made of it follows
    assert found["first"].kappa == pytest.approx(0.5)


def test_a_material_that_the_scene_knows_otherwise_stays(oak, tmp_path):
    exported(tmp_path / "a.json")
    document = json.loads((tmp_path / "a.json").read_text())
    bpy.context.scene.haptics.materials.items["oak"].rho = 0.1
    assert bpy.ops.import_scene.haptic_scene(filepath=str(tmp_path / "a.json")) == {"FINISHED"}
    assert bpy.context.scene.haptics.materials.items["oak"].rho == pytest.approx(0.1)
    assert bpy.data.objects["first.001"].haptics.rho == pytest.approx(0.7)
    document["materials"].append(document["materials"][0])
    (tmp_path / "a.json").write_text(json.dumps(document))
    with pytest.raises(RuntimeError, match=r"/materials/3/name: there is a material 'oak' already"):
        bpy.ops.import_scene.haptic_scene(filepath=str(tmp_path / "a.json"))


def test_a_collection_has_the_materials_that_it_is_made_of(oak, tmp_path):
    some = bpy.data.collections.new("some")
    bpy.context.scene.collection.children.link(some)
    some.objects.link(bpy.data.objects["first"])
    exported(tmp_path / "a.json", collection="some")
    assert [item.name for item in read_export(tmp_path / "a.json").materials] == ["oak"]
