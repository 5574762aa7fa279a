"""Objects marked as assets carry their haptics into other files: listener rigs, materials, and
sources with their signals."""

import bpy
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
