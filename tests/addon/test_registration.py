"""Register and unregister leave Blender as it was."""

import bpy
import haptic_tracing


def _registered() -> tuple[object, ...]:
    classes = sorted(name for name in dir(bpy.types) if name.lower().startswith("haptic"))
    operators = sorted(dir(bpy.ops.haptic)) if hasattr(bpy.ops, "haptic") else []
    handlers = {
        event: [h.__module__ for h in getattr(bpy.app.handlers, event) if "haptic" in h.__module__]
        for event in dir(bpy.app.handlers)
        if isinstance(getattr(bpy.app.handlers, event), list)
    }
    properties = hasattr(bpy.types.Object, "haptics"), hasattr(bpy.types.Scene, "haptics")
    return classes, operators, {k: v for k, v in handlers.items() if v}, *properties


def test_unregister_leaves_no_class_operator_handler_or_property() -> None:
    haptic_tracing.unregister()
    empty = _registered()
    for _ in range(3):
        haptic_tracing.register()
        assert _registered() != empty
        haptic_tracing.unregister()
        assert _registered() == empty
    assert empty == ([], [], {}, False, False)
    haptic_tracing.register()


def test_handlers_survive_loading_a_file() -> None:
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    handlers = [h for h in bpy.app.handlers.frame_change_post if "haptic" in h.__module__]
    assert len(handlers) == 1
