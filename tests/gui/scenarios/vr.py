"""VR sessions against an OpenXR runtime: known tracks are felt through the controllers, and nothing
is left of them after stops of every kind. The judge is the log of the runtime's calls."""

import json
import time

import addon_utils
import bpy
import numpy as np
from vr_stage import KEY, Stage

RATE, BLOCK = 8000, 1 / 24
SECONDS = 4.0
ONSETS = (0.3, 0.72, 1.15, 1.63, 2.04, 2.51, 2.97, 3.46)


def tracks():
    t = np.arange(round(SECONDS * RATE)) / RATE
    blows = [
        np.where(t >= at, np.exp(-np.clip(t - at, 0, None) / 0.06), 0.0)
        * np.sin(2 * np.pi * 170 * (t - at))
        for at in ONSETS
    ]
    return {
        "steady": 0.4 * np.sin(2 * np.pi * 150 * t),
        "swept": 0.4 * np.sin(2 * np.pi * (80 * t + 25 * t**2)),
        "blows": 0.8 * sum(blows),
    }


def play(stage, samples):
    """Blocks of frames of the timeline to the left controller; sent early, so that a busy machine
    makes no gap between them. Returns when the first sample is due."""
    begun, number = time.perf_counter() + 0.5, 0
    while number * BLOCK < SECONDS:
        while time.perf_counter() >= begun + number * BLOCK - 0.4 and number * BLOCK < SECONDS:
            first, last = (round(n * BLOCK * RATE) for n in (number, number + 1))
            block = np.zeros((2, last - first))
            block[0] = samples[first:last]
            stage.output.send(block, begun + number * BLOCK)
            number += 1
        yield 0.001
    yield 1.2
    return begun


def steps(window):
    stage = Stage(window)
    yield
    seen = window.seen
    seen["nothing is offered without a session"] = stage.outputs.found(KEY) is None
    yield from stage.toggle()
    maps = bpy.context.window_manager.xr_session_state.actionmaps
    seen["no action map is left"] = len(maps) == 0
    yield from stage.connect()
    seen["is in the list"] = "left, right" in stage.outputs.inventory().devices[0].title
    for name, samples in tracks().items():
        stage.mark(name)
        stage.sent[name] = yield from play(stage, samples)
    yield from window.screenshot("vr_controllers")
    for name, ends in ENDS.items():
        if stage.output is None:
            if not stage.runs:
                yield from stage.toggle()
            yield from stage.connect()
        stage.mark(name)
        stage.output.send(np.full((2, 4000), 0.5) * np.sin(np.arange(4000)))
        yield 0.2
        seen[f"vibrates before {name}"] = not stage.output.is_silent
        last = stage.output
        yield from ends(stage)
        seen[f"silent after {name}"] = last.is_silent
    seen["is offered until the session ends"] = stage.outputs.found(KEY) is None
    yield from beside_scene_inspection(stage)
    stage.mark("disable")
    stage.output.send(np.full((2, 4000), 0.5) * np.sin(np.arange(4000)))
    yield 0.3
    bpy.ops.preferences.addon_disable(module="bl_ext.user_default.haptic_tracing")
    yield 0.5
    seen["others work after disabling"] = grip() != [0.0, 0.0, 0.0]
    yield from stage.toggle()
    addon_utils.disable("viewport_vr_preview")
    bpy.ops.preferences.addon_enable(module="bl_ext.user_default.haptic_tracing")
    stage.ended = True
    yield
    data = {
        "ticks": stage.ticks,
        "calls": stage.called,
        "marks": stage.marks,
        "sent": stage.sent,
        "tracks": {name: samples.tolist() for name, samples in tracks().items()},
        "onsets": ONSETS,
    }
    (window.folder / "vr.json").write_text(json.dumps(data))


def grip():
    state = bpy.context.window_manager.xr_session_state
    return list(state.controller_grip_location_get(bpy.context, 0))


def rest(stage):
    stage.outputs.rest()
    yield 0.5


def undo(stage):
    with stage.window.context():
        bpy.ops.ed.undo_push(message="before")
        bpy.ops.ed.undo_push(message="after")
        bpy.ops.ed.undo()
    yield 0.5


def disconnect(stage):
    bpy.ops.haptic.connect_device(device=KEY)
    yield 0.3


def panic(stage):
    bpy.ops.haptic.panic()
    yield 0.3


def load(stage):
    def read():  # outside of the override of the context, whose window is freed
        bpy.ops.wm.read_homefile(use_factory_startup=False)

    bpy.app.timers.register(read)
    yield 2.0
    stage.window.seen["session after loading"] = stage.runs or "ended"


def session_end(stage):
    yield from stage.toggle()


ENDS = {
    "rest": rest,
    "undo": undo,
    "disconnecting": disconnect,
    "panic": panic,
    "loading": load,
    "the session's end": session_end,
}


def beside_scene_inspection(stage):
    """With the actions of the add-on that comes with Blender."""
    seen = stage.window.seen
    addon_utils.enable("viewport_vr_preview", default_set=False)
    yield from stage.toggle()
    state = bpy.context.window_manager.xr_session_state
    maps = {one.name: {item.name for item in one.actionmap_items} for one in state.actionmaps}
    seen["its maps are as they were"] = (
        sorted(maps) == ["blender_default", "blender_default_gamepad"]
        and not any("haptic_tracing" in items for items in maps.values())
        and "teleport" in maps["blender_default"]
    )
    yield from stage.connect()
    yield 1.0
    seen["its poses come"] = grip() != [0.0, 0.0, 0.0]
    seen["its actions have a state"] = (
        len(state.action_state_get(bpy.context, "blender_default", "teleport", "/user/hand/left"))
        == 2
    )
    stage.mark("beside")
    stage.output.send(np.full((2, 4000), 0.5) * np.sin(np.arange(4000)))
    yield 0.7
    seen["called beside it"] = stage.output.status.written > 5
    seen["none was refused"] = stage.output.status.failed_writes == 0
