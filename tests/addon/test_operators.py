"""Operators: what they do, what they report, and why they can't."""

import bpy
import pytest
from haptic_tracing.addon.operators import adding
from haptic_tracing.core.scene.body import DEFAULT_LISTENERS


def _select(*objects):
    for obj in bpy.context.selected_objects:
        obj.select_set(False)
    for obj in objects:
        obj.select_set(True)
    bpy.context.view_layer.objects.active = objects[0] if objects else None


@pytest.mark.parametrize("name", ["make_objects", "add_listener", "clear"])
def test_operators_on_a_selection_say_that_they_need_one(name):
    with pytest.raises(RuntimeError, match="Select one or more objects first"):
        getattr(bpy.ops.haptic, name)()


@pytest.mark.parametrize("name", ["add_source", "add_default_listeners"])
def test_operators_on_the_active_object_say_that_they_need_one(name):
    with pytest.raises(RuntimeError, match="Select an object first"):
        getattr(bpy.ops.haptic, name)()


def test_make_haptic_tags_what_has_a_surface(add_box, add_empty):
    box, empty = add_box("box", (0, 0, 0), (1, 1, 1), haptic=False), add_empty("empty")
    _select(box, empty)
    assert bpy.ops.haptic.make_objects() == {"FINISHED"}
    assert box.haptics.enabled
    assert not empty.haptics.enabled
    _select(empty)
    with pytest.raises(RuntimeError, match="surface"):
        bpy.ops.haptic.make_objects()


def test_a_source_on_a_mesh_makes_it_haptic_and_on_a_free_empty_is_refused(add_box, add_empty):
    box, empty = add_box("box", (0, 0, 0), (1, 1, 1), haptic=False), add_empty("empty")
    _select(box)
    bpy.ops.haptic.add_source(signal="PULSE")
    assert box.haptics.enabled
    assert box.haptics.source.enabled
    assert box.haptics.source.signal == "PULSE"
    _select(empty)
    with pytest.raises(RuntimeError, match="parent it to a haptic object"):
        bpy.ops.haptic.add_source()
    empty.parent = box
    bpy.ops.haptic.add_source()
    assert empty.haptics.source.enabled
    assert not empty.haptics.enabled


def test_twelve_listeners_are_the_default_body_parts_inside_the_body(add_box):
    body = add_box("body", (1, 2, 3), (0.5, 0.3, 1.8), haptic=False)
    _select(body)
    bpy.ops.haptic.add_default_listeners()
    bpy.context.view_layer.update()
    listeners = {child.haptics.listener.body_part: child for child in body.children}
    assert set(listeners) == set(DEFAULT_LISTENERS)
    for part, child in listeners.items():
        x, y, z = body.matrix_world.inverted() @ child.matrix_world.translation
        assert max(abs(x), abs(y), abs(z)) <= 0.5
        assert (x > 0) == part.endswith(".L")


def test_clear_takes_the_roles_and_keeps_the_settings(add_box):
    box = add_box("box", (0, 0, 0), (1, 1, 1))
    box.haptics.kappa = 0.7
    box.haptics.source.enabled = box.haptics.listener.enabled = True
    _select(box)
    bpy.ops.haptic.clear()
    assert not (box.haptics.enabled or box.haptics.source.enabled or box.haptics.listener.enabled)
    assert box.haptics.kappa == pytest.approx(0.7)


def test_select_object_selects_by_name_and_says_when_it_is_gone(add_box):
    first, second = add_box("first", (0, 0, 0), (1, 1, 1)), add_box("second", (3, 0, 0), (1, 1, 1))
    _select(first)
    assert bpy.ops.haptic.select_object(name="second") == {"FINISHED"}
    assert bpy.context.selected_objects == [second]
    assert bpy.ops.haptic.select_object(name="nobody") == {"CANCELLED"}


def test_trace_frame_says_when_nothing_is_tagged(add_box):
    assert bpy.ops.haptic.trace_frame() == {"CANCELLED"}
    add_box("box", (0, 0, 0), (1, 1, 1))
    assert bpy.ops.haptic.trace_frame() == {"FINISHED"}


@pytest.mark.parametrize(
    "name",
    [
        "select_object",
        "connect_device",
        "copy_udev_rule",
        "choose_actuator",
        "use_signal",
        "cancel_tracing",
    ],
)
def test_search_finds_no_operator_that_only_its_button_can_use(name):
    operator = getattr(bpy.types, f"HAPTIC_OT_{name}")
    assert "INTERNAL" in operator.bl_options


def test_a_medium_surrounds_what_is_not_evaluated_yet(add_box, monkeypatch):
    """As after the undo with which Blender begins when settings are adjusted."""
    box = add_box("box", (0, 0, 0), (1, 1, 1))
    _select(box)

    operator = adding.HAPTIC_OT_add_medium
    execute = operator.execute

    def moved_and_executed(self, context):  # `bpy.ops` has evaluated the scene before
        box.location = 3, 2, 1
        return execute(self, context)

    monkeypatch.setattr(operator, "execute", moved_and_executed)
    bpy.ops.haptic.add_medium()
    assert tuple(bpy.data.objects["Air"].location) == (3, 2, 1)
