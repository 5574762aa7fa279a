"""Register and unregister leave Blender as it was."""

import subprocess
import sys

import bpy
import haptic_tracing
import pytest


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


@pytest.mark.slow
def test_registering_does_not_load_what_computes():
    """It loads the declarations of the core, but neither signals nor anything above the scene."""
    report = (
        "print(*sorted(name for name in sys.modules if name.startswith('haptic_tracing.core.')))"
    )
    code = f"import bpy, haptic_tracing, sys; haptic_tracing.register(); {report}"
    printed = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    ).stdout.split()
    loaded = [
        name.removeprefix("haptic_tracing.core.")
        for name in printed
        if name.startswith("haptic_tracing.core.")
    ]
    assert "scene.values" in loaded
    computing = ("signals.", "contacts.", "graph.", "propagation.", "render.", "tracer", "design.")
    assert [name for name in loaded if name.startswith(computing)] == []
