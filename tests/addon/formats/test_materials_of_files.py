"""The library of haptic materials in files."""

import bpy
import pytest
from haptic_tracing.addon.authoring import materials
from haptic_tracing.addon.properties.materials import add_material
from haptic_tracing.core.formats.haptic_scene import read_export
from haptic_tracing.core.scene.library import LibraryMaterial
from scene_files import exported


@pytest.fixture
def oak(add_box):
    """Two boxes of oak, of which one has a kappa of its own, and a box of what
    no library knows."""
    scene = bpy.context.scene
    values = {"kappa": 0.3, "rho": 0.7, "wave_speed": 3800.0}
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


def test_the_library_is_written_with_what_objects_name(oak, tmp_path):
    exported(tmp_path / "a.json")
    export = read_export(tmp_path / "a.json")
    assert export.materials == (
        LibraryMaterial("oak", **oak),
        LibraryMaterial("nothing is made of it", 0.9, 0.9),
        LibraryMaterial("ebony", 0.1, 0.6),
    )


def test_a_collection_has_the_materials_that_it_is_made_of(oak, tmp_path):
    some = bpy.data.collections.new("some")
    bpy.context.scene.collection.children.link(some)
    some.objects.link(bpy.data.objects["first"])
    exported(tmp_path / "a.json", collection="some")
    assert [item.name for item in read_export(tmp_path / "a.json").materials] == ["oak"]
