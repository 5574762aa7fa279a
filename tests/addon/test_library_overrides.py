"""Library overrides: objects and node groups of another file are linked and overridden, and every
edit survives saving and reloading."""

import itertools
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import bpy
import pytest
from haptic_tracing.addon.blender.polling import editable
from haptic_tracing.addon.registration.properties import CLASSES
from haptic_tracing.addon.session import session


def _library(path: Path, fill: bool = False) -> None:
    """A file with a box and a node group; ``fill``: with haptic values and items of their own."""
    bpy.ops.mesh.primitive_cube_add()
    bpy.context.object.name = "Box"
    tree = bpy.data.node_groups.new("Signal", "ShaderNodeTree")
    if fill:
        bpy.context.object.haptics.source.sound.gain = 3.0
        bpy.context.object.haptics.kappa = 0.4
        for name in "ab":
            tree.haptics.emphases.add().name = name
    bpy.data.libraries.write(str(path), {bpy.context.object, tree})
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)


def _overridden(path: Path) -> tuple[Any, Any]:
    """Overrides of the box and the node group of a library."""
    with bpy.data.libraries.load(str(path), link=True) as (_, wanted):
        wanted.objects, wanted.node_groups = ["Box"], ["Signal"]
    box, tree = wanted.objects[0].override_create(), wanted.node_groups[0].override_create()
    speaker = bpy.data.objects.new("Speaker", bpy.data.speakers.new("Speaker"))
    speaker.haptics.source.drawing = tree  # without a user, it would not be saved
    for obj in (box, speaker):
        bpy.context.scene.collection.objects.link(obj)
    return box, tree


def _reload(path: Path) -> tuple[Any, Any]:
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    bpy.ops.wm.open_mainfile(filepath=str(path))
    return tuple(
        next(block for block in blocks if block.override_library)
        for blocks in (bpy.data.objects, bpy.data.node_groups)
    )


def _leaves(group: Any, path: str = "") -> Iterator[tuple[str, Any, Any]]:
    """Every property of ours with a value below a group: its path, the group that holds it, and its
    definition."""
    for name in type(group).__annotations__:
        prop = group.bl_rna.properties[name]
        if prop.type == "COLLECTION":
            for index, item in enumerate(getattr(group, name)):
                yield from _leaves(item, f"{path}{name}[{index}].")
        elif prop.type == "POINTER" and isinstance(
            inner := getattr(group, name), bpy.types.PropertyGroup
        ):
            yield from _leaves(inner, f"{path}{name}.")
        else:
            yield f"{path}{name}", group, prop


def _another(prop: Any, there: Any, serial: int) -> Any:
    """A value that differs from that in the library, for a property of any type."""
    if prop.type == "BOOLEAN":
        return not there
    if prop.type == "ENUM":
        return next(item.identifier for item in prop.enum_items if item.identifier != there)
    if prop.type == "STRING":
        return f"text {serial}"
    if prop.type == "POINTER":
        return {
            "Object": lambda: bpy.data.objects["Speaker"],
            "NodeTree": lambda: bpy.data.node_groups["Drawn Here"],
        }[prop.fixed_type.identifier]()
    place = 0.2537 + 0.011 * (serial % 50)
    value = prop.hard_min + place * (min(prop.hard_max, prop.hard_min + 10) - prop.hard_min)
    value = int(value) if prop.type == "INT" else value
    return [value] * prop.array_length if prop.is_array else value


def _values(group: Any) -> dict[str, Any]:
    def plain(value: Any) -> Any:
        if isinstance(value, bpy.types.ID):
            return value.name
        return tuple(value) if isinstance(value, bpy.types.bpy_prop_array) else value

    return {path: plain(getattr(holder, prop.identifier)) for path, holder, prop in _leaves(group)}


@pytest.mark.parametrize("fill", [False, True], ids=["plain", "with-haptics"])
def test_every_property_edited_in_an_override_survives_saving(tmp_path: Path, fill: bool) -> None:
    _library(tmp_path / "library.blend", fill)
    box, tree = _overridden(tmp_path / "library.blend")
    bpy.data.node_groups.new("Drawn Here", "ShaderNodeTree").haptics.is_signal = True
    tree.haptics.emphases.add().name = "c"
    serial = itertools.count()
    before = [_values(block.override_library.reference.haptics) for block in (box, tree)]
    for block, there in zip((box, tree), before, strict=True):
        for path, holder, prop in _leaves(block.haptics):
            setattr(holder, prop.identifier, _another(prop, there.get(path), next(serial)))
    edited = [_values(block.haptics) for block in (box, tree)]
    for own, there in zip(edited, before, strict=True):
        # Each differs from the library: it has to be stored.
        assert [path for path in own if own[path] == there.get(path)] == []
    groups = {
        type(holder).__name__.removeprefix("Haptic")
        for block in (box, tree)
        for _, holder, _ in _leaves(block.haptics)
    }
    assert groups >= {
        "ObjectProperties",
        "SourceProperties",
        "SoundProperties",
        "ListenerProperties",
        "ObjectMaterial",
    }
    assert groups >= {"ActuatorProperties", "Drawing", "Emphasis"}
    box, tree = _reload(tmp_path / "scene.blend")
    assert [_values(block.haptics) for block in (box, tree)] == edited
    box, tree = _reload(tmp_path / "scene.blend")  # and a second time, without an edit in between
    assert [_values(block.haptics) for block in (box, tree)] == edited


def test_later_edits_of_the_library_reach_what_the_override_did_not_change(tmp_path: Path) -> None:
    _library(tmp_path / "library.blend")
    box, _ = _overridden(tmp_path / "library.blend")
    box.haptics.source.sound.gain = 3.0
    _reload(tmp_path / "scene.blend")
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "library.blend"))
    there = bpy.data.objects["Box"].haptics
    there.kappa, there.source.sound.gain, there.source.sound.frequency = 0.75, 9.0, 90.0
    bpy.data.libraries.write(
        str(tmp_path / "library.blend"), {bpy.data.objects["Box"], bpy.data.node_groups["Signal"]}
    )
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "scene.blend"))
    own = next(obj for obj in bpy.data.objects if obj.override_library).haptics
    assert (own.kappa, own.source.sound.gain, own.source.sound.frequency) == (0.75, 3.0, 90.0)


def test_a_listener_added_to_an_override_feels_after_reloading(tmp_path: Path) -> None:
    _library(tmp_path / "library.blend")
    box, _ = _overridden(tmp_path / "library.blend")
    with bpy.context.temp_override(object=box, active_object=box, selected_objects=[box]):
        bpy.ops.haptic.add_listener()
        bpy.ops.haptic.add_source()
    _reload(tmp_path / "scene.blend")
    traced = session.trace(bpy.context.scene, bpy.context.evaluated_depsgraph_get())
    assert traced.amplitudes.shape == (1, 1) and traced.amplitudes[0, 0] > 0


def test_all_properties_of_all_groups_are_overridable() -> None:
    for group in CLASSES:
        overridable = {prop.identifier for prop in group.bl_rna.properties if prop.is_overridable}
        assert overridable == set(group.__annotations__)
    owners = bpy.types.Object, bpy.types.NodeTree, bpy.types.Scene
    assert all(owner.bl_rna.properties["haptics"].is_overridable for owner in owners)


def test_blender_overrides_no_scenes(tmp_path: Path) -> None:
    """Settings of a linked scene can therefore be changed only in its own file, whatever their
    properties allow."""
    bpy.context.scene.name = "Linked"
    bpy.data.libraries.write(str(tmp_path / "library.blend"), {bpy.context.scene})
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    with bpy.data.libraries.load(str(tmp_path / "library.blend"), link=True) as (_, wanted):
        wanted.scenes = ["Linked"]
    assert wanted.scenes[0].override_create() is None


@pytest.mark.parametrize("operator", ["make_objects", "add_source", "add_listener"])
def test_the_instance_of_a_linked_collection_says_what_to_do(tmp_path: Path, operator: str) -> None:
    collection = bpy.data.collections.new("Rig")
    collection.objects.link(bpy.data.objects.new("Body", bpy.data.meshes.new("Body")))
    bpy.data.libraries.write(str(tmp_path / "library.blend"), {collection})
    bpy.data.collections.remove(collection)
    with bpy.data.libraries.load(str(tmp_path / "library.blend"), link=True) as (_, wanted):
        wanted.collections = ["Rig"]
    instance = bpy.data.objects.new("Rig", None)
    instance.instance_type, instance.instance_collection = "COLLECTION", wanted.collections[0]
    bpy.context.scene.collection.objects.link(instance)
    chosen = bpy.context.temp_override(
        object=instance, active_object=instance, selected_objects=[instance]
    )
    cure = (
        "Make Instances Real" if operator == "make_objects" else "Object > Library Override > Make"
    )
    with chosen, pytest.raises(RuntimeError, match=cure):
        getattr(bpy.ops.haptic, operator)()


def _rig(path: Path, overridden: bool) -> Any:
    """A linked collection with a listener, overridden or not, that is the active one, as after a
    click in the Outliner."""
    collection = bpy.data.collections.new("Rig")
    listener = bpy.data.objects.new("hand.L", None)
    listener.haptics.listener.enabled, listener.haptics.listener.body_part = True, "hand.L"
    collection.objects.link(listener)
    bpy.data.libraries.write(str(path), {collection})
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    with bpy.data.libraries.load(str(path), link=True) as (_, wanted):
        wanted.collections = ["Rig"]
    (rig,) = wanted.collections
    scene, layer = bpy.context.scene, bpy.context.view_layer
    if overridden:
        rig = rig.override_hierarchy_create(scene, layer)
    else:
        scene.collection.children.link(rig)
    layer.active_layer_collection = layer.layer_collection.children[rig.name]
    assert bpy.context.collection == rig
    return rig


@pytest.mark.parametrize("overridden", [False, True])
def test_what_is_added_stands_beside_a_collection_of_another_file(
    tmp_path: Path, overridden: bool
) -> None:
    _rig(tmp_path / "library.blend", overridden)
    bpy.ops.haptic.add_source_object(kind="SINE")
    bpy.ops.haptic.add_medium()
    bpy.ops.mesh.primitive_cube_add()
    bpy.ops.haptic.add_default_listeners()
    added = {"Shaker", "Air", "Cube hand.L", "Cube hand.R"}
    assert added <= set(bpy.context.scene.collection.objects.keys())


def test_system_overrides_are_no_objects_to_edit(tmp_path: Path) -> None:
    _library(tmp_path / "library.blend")
    box, _ = _overridden(tmp_path / "library.blend")
    assert editable([box]) == [box]
    box.override_library.is_system_override = True
    assert editable([box, box.override_library.reference]) == []
