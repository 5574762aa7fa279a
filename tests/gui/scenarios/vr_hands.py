"""Hands in a VR session at given places of the demo scene: what is called, how soon, how often the
session draws with and without them, and what is recorded."""

import json
import time

import bpy
import numpy as np
from mathutils import Vector
from vr_stage import Stage

AWAY = ((50.0, 50.0, 50.0), (1.0, 0.0, 0.0, 0.0))
SECONDS, TURNS = 2.5, 6


def place_on(name):
    """The middle of the top of an object's bounding box."""
    obj = bpy.data.objects[name]
    corners = np.array([obj.matrix_world @ Vector(c) for c in obj.bound_box])
    middle = (corners.min(axis=0) + corners.max(axis=0)) / 2
    return ((*middle[:2].tolist(), float(corners[:, 2].max())), (1.0, 0.0, 0.0, 0.0))


class Hands(Stage):
    """The session with hands at places of ours, and when they were asked for."""

    def __init__(self, window):
        super().__init__(window)
        self.places, self.asked = {"left": AWAY, "right": AWAY}, []
        self.actions.grips = self.grips
        self.controllers, self.failures = window.module("plugins.vr.controllers"), []

    def grips(self):
        self.asked.append(time.perf_counter())
        hands = self.controllers.hands()
        if hands is not None and hands.failure is not None:
            self.failures.append(repr(hands.failure))
        return dict(self.places)

    def amplitudes(self, since, hand):
        return [call[2] for call in self.called if call[0] > since and call[1] == hand]


def steps(window):
    stage, seen = Hands(window), window.seen
    scene = window.module("sample_scenes").build_sample("jackhammer_bench")
    bpy.context.window.scene = scene
    yield 1.0
    tool = next(obj.name for obj in scene.objects if "jackhammer" in obj.name.lower())
    before = names()
    yield from stage.toggle()
    yield from window.wait_until(lambda: stage.outputs.found("vr-controllers") is not None)
    bpy.ops.haptic.vr_hands()
    seen["controllers are connected with the hands"] = stage.output is not None
    stage.mark("away")
    yield 2.0
    seen["nothing is felt far away"] = stage.called == []
    stage.places["left"] = place_on(tool)
    for turn in range(TURNS):  # a busy machine is as busy with as without
        for name in ("with", "without"):
            stage.mark(f"{name} {turn}")
            yield SECONDS
            bpy.ops.haptic.vr_hands()
    stage.mark("felt")
    yield SECONDS
    stage.mark("counted")
    begun = stage.marks[-2][1]
    seen["the jackhammer is felt on the left"] = (
        max(stage.amplitudes(begun, "left"), default=0) > 0.05
    )
    seen["and not on the right"] = stage.amplitudes(begun, "right") == []
    with window.context():
        bpy.context.view_layer.objects.active = bpy.data.objects[tool]
        bpy.data.objects[tool].select_set(True)
        bpy.ops.view3d.view_selected()
    yield 1.0
    yield from window.screenshot("vr_hands")
    stage.mark("plays")
    bpy.ops.haptic.record_hands()
    yield from window.play_frames(12)
    seen["felt while it plays"] = (
        max(stage.amplitudes(stage.marks[-1][1], "left"), default=0) > 0.05
    )
    seen["no object was made"] = names() == before
    with window.context():
        bpy.ops.ed.undo_push(message="before")
        bpy.ops.haptic.record_hands("EXEC_DEFAULT", True)
    yield 0.5
    made = [obj for obj in bpy.data.objects if obj.name not in before]
    seen["recorded hands"] = sorted(obj.name for obj in made if obj.haptics.enabled) == [
        "VR hand, left",
        "VR hand, right",
    ]
    seen["with keys"] = all(obj.animation_data is not None for obj in made if obj.haptics.enabled)
    with window.context():
        bpy.ops.ed.undo()
    yield 0.5
    seen["undone"] = names() == before
    seen["no frame failed"] = stage.failures == []
    yield from stage.toggle()
    stage.ended = True
    yield
    data = {
        "calls": stage.called,
        "marks": stage.marks,
        "asked": stage.asked,
        "ticks": stage.ticks,
    }
    (window.folder / "vr_hands.json").write_text(json.dumps(data))


def names():
    return sorted(obj.name for obj in bpy.data.objects)
