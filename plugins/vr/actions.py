"""The OpenXR action by which the controllers vibrate, and its calls."""

from __future__ import annotations

from typing import Any

import bpy

from ...addon.blender.units import metres_per_unit

ACTION = "haptic_tracing"
HANDS = {"left": "/user/hand/left", "right": "/user/hand/right"}
"""OpenXR's paths of the controllers, by actuator."""
_PROFILES = {
    "khr/simple_controller": "",
    "oculus/touch_controller": "",
    "valve/index_controller": "",
    "htc/vive_controller": "",
    "microsoft/motion_controller": "",
    "hp/mixed_reality_controller": "vr_actions_enable_reverb_g2",
    "htc/vive_cosmos_controller": "vr_actions_enable_vive_cosmos",
    "htc/vive_focus3_controller": "vr_actions_enable_vive_focus",
    "huawei/controller": "vr_actions_enable_huawei",
}
"""Controllers that vibrate, and the switch of VR Scene Inspection for those that need an extension
of OpenXR: without it, a session in which they are named may not start."""
_LEVEL = 1e-5  # between components of a rotation
_POSES = {"grip": "/input/grip/pose", "aim": "/input/aim/pose"}
_UNITS_PER_SECOND = {(5, 2): 1e6}
"""By version of Blender, what makes a second of `haptic_action_apply`, where that was tried. 5.2
hands milliseconds to OpenXR as nanoseconds. Elsewhere seconds are taken as documented: a call is
then too short rather than hours too long."""


def session_state() -> Any:
    """The state of the session, None without one."""
    return bpy.context.window_manager.xr_session_state


def is_running() -> bool:
    """Whether a session runs."""
    state = session_state()
    return state is not None and bool(state.is_running(bpy.context))


def grips() -> dict[str, tuple[Any, Any]]:
    """Location [m, world] and rotation (w, x, y, z) of the grip of each controller that is tracked.

    Blender has others at the origin of the tracked space, turned as that is, level to float32's
    precision: no hand holds a controller like this.
    """
    state = session_state()
    context = bpy.context
    metres = metres_per_unit(context.scene)
    found = {}
    for number, hand in enumerate(HANDS):
        w, x, y, z = state.controller_grip_rotation_get(context, number)
        if abs(w - x) > _LEVEL or abs(y - z) > _LEVEL:
            location = state.controller_grip_location_get(context, number)
            found[hand] = tuple(metres * value for value in location), (w, x, y, z)
    return found


def vibrate(action_set: str, hand: str, amplitude: float, frequency: float, seconds: float) -> bool:
    """Let a controller vibrate from now on. Returns whether the session accepted that.

    Args:
        action_set: that has the action.
        hand: left or right.
        amplitude: 0 to 1.
        frequency: [Hz].
        seconds: how long.
    """
    duration = seconds * _UNITS_PER_SECOND.get(bpy.app.version[:2], 1.0)
    return bool(
        session_state().haptic_action_apply(
            bpy.context, action_set, ACTION, HANDS[hand], duration, frequency, amplitude
        )
    )


def stop(action_set: str, hand: str) -> bool:
    """Stop a controller."""
    session_state().haptic_action_stop(bpy.context, action_set, ACTION, HANDS[hand])
    return True


def create() -> str:
    """Add the action to the active action set, the first one that has a controller's pose, or to
    one of our own. Returns the name of that set; "" if the session refuses.

    The descriptions are removed from the action maps again, which another add-on may store.
    """
    state = session_state()
    context = bpy.context
    maps = [one for one in state.actionmaps if any(_is_grip(item) for item in one.actionmap_items)]
    own = not maps
    if own:
        maps = [state.actionmaps.new(state, ACTION, True)]
    described = maps[0]
    name = str(maps[0].name)
    items = [_item(described, ACTION, "VIBRATION", "/output/haptic")]
    if own:
        items += [_item(described, pose, "POSE", path) for pose, path in _POSES.items()]
        items[1].pose_is_controller_grip = items[2].pose_is_controller_aim = True
    made = not own or state.action_set_create(context, described)
    for item in items:
        made = made and state.action_create(context, described, item)
        for binding in item.bindings:
            made = made and state.action_binding_create(context, described, item, binding)
    if own and made:
        made = state.controller_pose_actions_set(context, name, *_POSES)
        made = made and state.active_action_set_set(context, name)
    if own:
        state.actionmaps.remove(state, described)
    else:
        described.actionmap_items.remove(items[0])
    return name if made else ""


def _is_grip(item: Any) -> bool:
    return item.type == "POSE" and item.pose_is_controller_grip


def _item(described: Any, name: str, kind: str, component: str) -> Any:
    """A new action of both hands in an action map, bound for every controller."""
    item = described.actionmap_items.new(name, True)
    item.type = kind
    for path in HANDS.values():
        item.user_paths.new(path)
    for profile, switch in _PROFILES.items():
        if not switch or getattr(bpy.context.scene, switch, False):
            binding = item.bindings.new(profile.replace("/", "_"), True)
            binding.profile = f"/interaction_profiles/{profile}"
            for _ in HANDS:
                binding.component_paths.new(component)
    return item
