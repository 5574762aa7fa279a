"""Haptics in glTF files as Blender's own exporter writes them, read as plain JSON and by Blender's
own importer."""

import json
import sys

import bpy
import haptic_tracing
import pytest
from haptic_tracing.addon.io.frame_scene import scene_of_frame
from haptic_tracing.core.formats.provenance import provenance_of


@pytest.fixture
def gltf(tmp_path):
    """Exports the scene with the add-on enabled in the preferences, where the exporter looks for
    it, and parses the file."""
    addon = bpy.context.preferences.addons.new()
    addon.module = haptic_tracing.__name__
    assert sys.modules[addon.module] is haptic_tracing

    def export(**options):
        path = tmp_path / "scene.gltf"
        assert bpy.ops.export_scene.gltf(
            filepath=str(path), export_format="GLTF_SEPARATE", **options
        ) == {"FINISHED"}
        return json.loads(path.read_text())

    yield export
    bpy.context.preferences.addons.remove(addon)


@pytest.fixture
def bench(add_box, add_empty):
    ground = add_box("ground", (0, 0, -0.5), (4, 4, 1))
    ground.haptics.source.enabled, ground.haptics.source.frequency = True, 25.0
    ground.haptics.source.signal = "PULSE"
    seat = add_box("seat", (1, 0.5, 0.25), (0.5, 0.5, 0.5))
    seat.haptics.kappa, seat.haptics.rho = 0.3, 0.7
    seat.haptics.function, seat.haptics.alpha = "exponential", 0.4
    seat.data = ground.data  # the same mesh, another material
    hips = add_empty("hips", (0, 0, 0.5), parent=seat)
    hips.haptics.listener.enabled, hips.haptics.listener.body_part = True, "hips"
    add_box("scenery", (5, 5, 5), (1, 1, 1), haptic=False)
    bpy.context.view_layer.update()
    return bpy.context.scene


def nodes_of(document):
    return {node["name"]: node for node in document["nodes"]}


def test_roles_properties_functions_and_contacts_are_extras_of_nodes(bench, gltf):
    document = gltf()
    nodes = nodes_of(document)
    assert "extras" not in nodes["scenery"]
    ground, seat, hips = (
        nodes[name]["extras"]["haptic_tracing"] for name in ("ground", "seat", "hips")
    )
    assert (
        ground["object"] == {"kappa": 0.1, "rho": 0.9}
        and ground["source"]["signal"]["frequency"] == 25.0
    )
    assert seat["object"] == {
        "kappa": 0.3,
        "rho": 0.7,
        "propagation": {"function": "exponential", "alpha": 0.4},
    }
    assert hips["listener"] == {"body_part": "hips", "limiter": True} and "object" not in hips
    assert document["scenes"][0]["extras"]["haptic_tracing"]["settings"]["strategy"] == "best_path"
    contacts = ground["contacts"]
    assert {contact["object"] for contact in contacts} == {"seat"}
    for contact in contacts:
        for place in contact[
            "positions"
        ]:  # in the axes of the file: y is up, and the contact is at height 0
            assert abs(place[1]) < 0.01 and 0.7 < place[0] < 1.3 and -0.8 < place[2] < -0.2
    assert "extensions" not in document


def test_the_head_says_where_the_haptics_come_from(bench, gltf):
    """Khronos allows any extras of `asset`; its generator stays Blender's."""
    asset = gltf()["asset"]
    scene = scene_of_frame(bench, bpy.context.evaluated_depsgraph_get())
    assert asset["extras"]["haptic_tracing"] == provenance_of(scene)
    assert "Blender" in asset["generator"] and asset["version"] == "2.0"
    bench.haptic_gltf.use_extras = False
    assert "extras" not in gltf()["asset"]


def test_axes_follow_the_exporter(bench, gltf):
    (contact, *_) = nodes_of(gltf(export_yup=False))["ground"]["extras"]["haptic_tracing"][
        "contacts"
    ]
    assert abs(contact["positions"][0][2]) < 0.01


def test_haptic_materials_under_a_name_that_is_set(bench, gltf):
    bench.haptic_gltf.use_material = True
    bench.haptic_gltf.material_name = "MPEG_material_haptic"
    bpy.data.objects["seat"].haptics.material.name = "old oak"
    document = gltf()
    assert (
        document["extensionsUsed"] == ["MPEG_material_haptic"]
        and "extensionsRequired" not in document
    )
    materials = document["extensions"]["MPEG_material_haptic"]["materials"]
    nodes = nodes_of(document)
    found = {}
    for name in ("ground", "seat"):
        mesh = document["meshes"][nodes[name]["mesh"]]
        found[name] = materials[mesh["extensions"]["MPEG_material_haptic"]["hapticMaterialIndex"]]
    assert found["seat"] == {"name": "old oak", "extras": {"kappa": 0.3, "rho": 0.7}}
    assert found["ground"]["extras"] == {"kappa": 0.1, "rho": 0.9}
    assert "extensions" not in document["meshes"][nodes["scenery"]["mesh"]]


def test_nothing_where_it_is_not_wanted_or_nothing_is_tagged(bench, gltf):
    bench.haptic_gltf.use_extras = False
    assert "haptic_tracing" not in json.dumps(gltf())
    bench.haptic_gltf.use_extras = True
    for obj in bench.objects:
        obj.haptics.enabled = obj.haptics.source.enabled = obj.haptics.listener.enabled = False
    assert "haptic_tracing" not in json.dumps(gltf())


def test_blenders_importer_gives_the_roles_back(bench, gltf, traced, tmp_path):
    before = traced()
    expected = {
        (source.name, listener.name): before.amplitudes[s, i]
        for s, source in enumerate(before.sources)
        for i, listener in enumerate(before.listeners)
    }
    gltf()
    for obj in list(bpy.data.objects):
        bpy.data.objects.remove(obj)
    bpy.ops.import_scene.gltf(filepath=str(tmp_path / "scene.gltf"))
    seat = bpy.data.objects["seat"]
    assert (
        seat.haptics.enabled
        and seat.haptics.kappa == pytest.approx(0.3)
        and seat.haptics.function == "exponential"
    )
    assert "haptic_tracing" not in seat and not bpy.data.objects["scenery"].haptics.enabled
    bpy.context.view_layer.update()
    after = traced()
    for s, source in enumerate(after.sources):
        for i, listener in enumerate(after.listeners):
            assert after.amplitudes[s, i] == pytest.approx(
                expected[source.name, listener.name], rel=1e-3
            )


def test_odd_extras_are_left_out(bench, gltf, tmp_path):
    document = gltf()
    node = nodes_of(document)["seat"]
    bad_object, bad_source = (
        {"object": {"kappa": "x", "rho": 1}},
        {"source": {"signal": {"signal": "odd"}}},
    )
    for odd in (3, {"object": 3}, bad_object, bad_source, {"listener": {"gain": -1}}):
        node["extras"]["haptic_tracing"] = odd
        (tmp_path / "odd.gltf").write_text(json.dumps(document))
        for obj in list(bpy.data.objects):
            bpy.data.objects.remove(obj)
        assert bpy.ops.import_scene.gltf(filepath=str(tmp_path / "odd.gltf")) == {"FINISHED"}
        assert (
            not bpy.data.objects["seat"].haptics.enabled
            and bpy.data.objects["ground"].haptics.enabled
        )


def test_the_exporters_panel_draws(bench, gltf, recording_layout):
    for name in (
        "glTF2ExportUserExtension",
        "glTF2ImportUserExtension",
        "draw_export",
        "draw_import",
    ):
        assert hasattr(haptic_tracing, name)
    assert not hasattr(haptic_tracing, "glTF2ExportUserExtensions")

    class Layout(recording_layout):
        def panel(self, name, default_closed):
            return self, self

    layout = Layout()
    bench.haptic_gltf.use_material = True
    haptic_tracing.draw_export(bpy.context, layout)
    assert layout.properties == ["use_extras", "use_material", "material_name"]
