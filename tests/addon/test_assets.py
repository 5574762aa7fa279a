"""Objects marked as assets carry their haptics into other files: listener rigs, materials, and
sources with their signals."""

import bpy
import pytest
from haptic_tracing.addon.authoring import materials
from haptic_tracing.core.scene.materials import MATERIALS


def test_an_asset_brings_its_roles_material_and_signal(scene, add_box, add_empty, tmp_path):
    drum = add_box("drum", (0, 0, 0), (1, 1, 1))
    materials.make_haptic(scene, {drum: MATERIALS["steel"]})
    kappa, rho = drum.haptics.kappa, drum.haptics.rho
    bpy.context.view_layer.objects.active = drum
    drum.haptics.source.enabled, drum.haptics.source.signal = True, "DRAWN"
    bpy.ops.haptic.draw_signal()
    drum.haptics.source.drawing.haptics.duration = 0.75
    hands = [add_empty(f"hand.{side}", (0, 0, 0.5), drum) for side in "LR"]
    for hand in hands:
        hand.haptics.listener.enabled = True
        hand.haptics.listener.body_part, hand.haptics.listener.gain = hand.name, 1.5
    rig = bpy.data.collections.new("Rig")
    for obj in (drum, *hands):
        rig.objects.link(obj)
    for marked in (drum, rig):
        marked.asset_mark()
    path = tmp_path / "library.blend"
    bpy.data.libraries.write(str(path), {drum, rig})
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    # What Blender does where an asset is dropped.
    with bpy.data.libraries.load(str(path), assets_only=True) as (there, wanted):
        assert there.objects == ["drum"] and there.collections == ["Rig"]
        wanted.collections = ["Rig"]
    bpy.context.scene.collection.children.link(wanted.collections[0])
    drum = bpy.data.objects["drum"]
    assert drum.haptics.enabled and (drum.haptics.kappa, drum.haptics.rho) == (kappa, rho)
    assert drum.haptics.source.drawing.haptics.duration == 0.75
    for side in "LR":
        listener = bpy.data.objects[f"hand.{side}"].haptics.listener
        assert (listener.enabled, listener.body_part, listener.gain) == (True, f"hand.{side}", 1.5)
    # The new file's library has no steel yet: one press adds it.
    assert drum.haptics.material.name not in bpy.context.scene.haptics.materials.items
    bpy.context.view_layer.objects.active = drum
    assert bpy.ops.haptic.new_material() == {"FINISHED"}
    item = bpy.context.scene.haptics.materials.items[drum.haptics.material.name]
    assert (item.kappa, item.rho) == (kappa, rho)


@pytest.mark.skipif(bpy.app.version < (4, 3), reason="Blender does not report imports")
@pytest.mark.parametrize("operator", ["append", "link"])
@pytest.mark.parametrize("again", [False, True])
def test_a_body_feels_in_another_file_what_it_felt_in_its_own(
    scene, add_box, traced, tmp_path, operator, again
):
    """The scene gets the rules of contacts of flesh, once."""
    floor = add_box("floor", (0, 0, -0.5), (4, 4, 1), haptic=False)
    hand = add_box("hand", (1, 0, 0.5), (1, 1, 1), haptic=False)
    materials.make_haptic(scene, {floor: MATERIALS["steel"], hand: MATERIALS["flesh"]})
    floor.haptics.source.enabled = hand.haptics.listener.enabled = True
    floor.haptics.source.amplitude = 0.5
    rules = [(row.first, row.second, row.function) for row in transmissions(scene)]
    felt = traced().amplitudes
    rig = bpy.data.collections.new("Rig")
    for obj in (floor, hand):
        rig.objects.link(obj)
    path = tmp_path / "rig.blend"
    bpy.data.libraries.write(str(path), {rig})
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.context.scene
    place = {"directory": f"{path}/Collection/", "filename": "Rig"}
    options = {"instance_collections": False} if operator == "link" else {}
    for _ in range(1 + again):
        getattr(bpy.ops.wm, operator)(**place, **options)
    if again:
        materials.make_haptic(scene, {add_box("arm", (9, 9, 9), (1, 1, 1)): MATERIALS["flesh"]})
    bpy.context.view_layer.update()
    assert [(row.first, row.second, row.function) for row in transmissions(scene)] == rules
    assert traced().amplitudes[0, 0] == pytest.approx(felt[0, 0], rel=1e-6)


def transmissions(scene):
    return scene.haptics.transmission_table.items
