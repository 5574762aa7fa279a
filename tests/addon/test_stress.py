"""Whatever is done to a scene in whatever order, what the session gives is what a trace from
nothing gives: never a wrong result.

python -m pytest tests/addon/test_stress.py --stress-seeds 20 --stress-operations 2000
"""

from __future__ import annotations

import random
from dataclasses import replace

import bpy
import numpy as np
import pytest
from bpy.app.handlers import persistent
from haptic_tracing.addon.scene_reader.reader import SceneReader
from haptic_tracing.addon.session import session, sessions
from haptic_tracing.core.tracer import Tracer

FRAMES = 30
MOST_BOXES = 12
SAME = 1e-3
"""Relative difference of gains: a contact is found again only where its bodies have moved by more
than 0.01 mm."""


def pytest_generate_tests(metafunc):
    if "seed" in metafunc.fixturenames:
        metafunc.parametrize("seed", range(metafunc.config.getoption("--stress-seeds")))


WEIGHTS = {
    "move": 8, "turn": 3, "material": 4, "source": 4, "tag": 2, "add": 3, "remove": 2, "rename": 2, "animate": 4, "setting": 2,
    "modify": 6, "select": 4, "unseen": 2, "share": 3, "vertex": 3, "rule": 2,
    "jump": 8, "run": 8, "nest": 4, "undo": 6, "redo": 4, "load": 1, "render": 1, "other_scene": 2, "back": 2,
}  # fmt: skip
"""How often each operation comes."""


class Stress:
    """A scene of boxes that are moved, edited, undone, loaded, rendered and removed: a method for
    each operation."""

    def __init__(self, seed, folder):
        self.random, self.file, self.done = random.Random(seed), str(folder / "stress.blend"), []
        scene = self.scene
        scene.render.engine, scene.cycles.samples = "CYCLES", 1
        scene.render.resolution_x = scene.render.resolution_y = 4
        scene.camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
        scene.collection.objects.link(scene.camera)
        mesh = bpy.data.meshes.new("box")
        mesh.use_fake_user = True  # it is saved where no box is left
        corners = [(x, y, z) for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)]
        mesh.from_pydata(
            corners,
            [],
            [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)],
        )
        for _ in range(6):
            self.add()
        for k, box in enumerate(self.boxes[:2]):
            box.haptics.source.enabled = True
            listener = bpy.data.objects.new(f"listener {k}", None)
            scene.collection.objects.link(listener)
            listener.parent, listener.haptics.listener.enabled = self.boxes[k + 2], True
        bpy.ops.ed.undo_push(message="begin")

    @property
    def scene(self):
        return bpy.context.scene

    @property
    def boxes(self):
        return sorted(
            (obj for obj in self.scene.objects if obj.type == "MESH"), key=lambda obj: obj.name
        )

    def step(self):
        name = self.random.choices(list(WEIGHTS), list(WEIGHTS.values()))[0]
        self.done.append(name)
        getattr(self, name)()

    def edited(self):
        if self.random.random() < 0.5:
            bpy.context.view_layer.update()
        bpy.ops.ed.undo_push(message=self.done[-1])

    def some_box(self):
        if not self.boxes:
            self.add()
        return self.random.choice(self.boxes)

    def place(self):
        """Near a grid where boxes touch, are apart, or overlap; never as deep along two axes, where
        either normal is right."""
        return tuple(
            self.random.choice((0.0, 0.5, 0.98, 1.3, 2.0)) + self.random.uniform(0.0, 0.05)
            for _ in range(3)
        )

    def move(self):
        self.some_box().location = self.place()
        self.edited()

    def turn(self):
        self.some_box().rotation_euler.z = self.random.choice((0.0, 0.1, 0.7854))
        self.edited()

    def material(self):
        box = self.some_box()
        box.haptics.kappa, box.haptics.rho = self.random.random(), self.random.uniform(0.1, 2.0)
        self.edited()

    def source(self):
        source = self.some_box().haptics.source
        source.enabled, source.amplitude = self.random.random() < 0.7, self.random.uniform(0.1, 1.0)
        self.edited()

    def tag(self):
        box = self.some_box()
        box.haptics.enabled = not box.haptics.enabled
        self.edited()

    def add(self):
        if len(self.boxes) < MOST_BOXES:
            box = bpy.data.objects.new("box", bpy.data.meshes["box"])
            self.scene.collection.objects.link(box)
            box.location, box.haptics.enabled = self.place(), True
        if self.done:
            self.edited()

    def remove(self):
        bpy.data.objects.remove(self.some_box())
        self.edited()

    def rename(self):
        self.some_box().name = f"{self.random.choice('abc')} {self.random.randrange(5)}"
        self.edited()

    def animate(self):
        box = self.some_box()
        if self.random.random() < 0.2:
            box.animation_data_clear()
        else:
            box.location = self.place()
            box.keyframe_insert("location", frame=self.random.randint(1, FRAMES))
        self.edited()

    def modify(self):
        self.change_modifiers()
        self.edited()

    def change_modifiers(self):
        """A modifier that empties the mesh or moves it away, at once or over the frames, comes, is
        switched, or goes; or what touches is chosen."""
        box = self.some_box()
        if self.random.random() < 0.3:
            box.haptics.surface = self.random.choice(("CONVEX_HULL", "SEEN", "SOLID", "SHELL"))
            return
        if box.modifiers and self.random.random() < 0.5:
            modifier = box.modifiers[0]
            if self.random.random() < 0.5:
                box.modifiers.remove(modifier)
            else:
                modifier.show_viewport = not modifier.show_viewport
        elif self.random.random() < 0.5:
            box.modifiers.new("mask", "MASK").vertex_group = (
                box.vertex_groups.get("none") or box.vertex_groups.new(name="none")
            ).name
        else:
            modifier = box.modifiers.new("array", "ARRAY")
            modifier.use_relative_offset, modifier.use_object_offset = False, True
            # Perhaps an animated one.
            modifier.offset_object = self.random.choice(
                [None, *(other for other in self.boxes if other != box)]
            )

    def share(self):
        """A box takes over the mesh of another one, or has a copy of its own."""
        box = self.some_box()
        box.data = self.some_box().data if self.random.random() < 0.5 else box.data.copy()
        self.edited()

    def vertex(self):
        """A corner of a mesh moves, of all boxes that share it."""
        mesh = self.some_box().data
        mesh.vertices[0].co.x -= 0.01
        mesh.update()
        self.edited()

    def rule(self):
        """Add a rule for contacts, or edit the first one."""
        rows = self.scene.haptics.transmission_table.items
        if len(rows) < 2:
            bpy.ops.haptic.add_rule(table="transmission_table")
        rows[0].first_kind, rows[0].first = "OBJECT", self.some_box().name
        rows[0].function = self.random.choice(("impedance", "identity"))
        self.edited()

    def select(self):
        """A click on another object."""
        box = self.some_box()
        box.select_set(not box.select_get())
        bpy.context.view_layer.objects.active = box
        self.edited()

    def unseen(self):
        """Frames come and modifiers change while tracing is off."""
        self.scene.haptics.tracing = False
        self.run()
        self.change_modifiers()
        self.run()
        self.scene.haptics.tracing = True
        self.edited()

    def setting(self):
        haptics = self.scene.haptics
        haptics.strategy = self.random.choice(("best_path", "as_in_the_paper"))
        haptics.contact_tolerance = self.random.choice((0.01, 0.02))
        self.edited()

    def jump(self):
        self.scene.frame_set(self.random.randint(1, FRAMES))

    def run(self):
        for _ in range(self.random.randint(1, 5)):
            self.scene.frame_set(self.scene.frame_current % FRAMES + 1)

    def nest(self):
        """Another add-on's handler comes to another frame while Blender is still at this one,
        before or after our own handler."""
        inside, frame = [], self.random.randint(1, FRAMES)

        @persistent
        def handler(scene, *_):
            if not inside:
                inside.append(scene)
                scene.frame_set(frame)

        handlers = bpy.app.handlers.frame_change_post
        handlers.insert(self.random.choice((0, len(handlers))), handler)
        try:
            self.scene.frame_set(self.random.randint(1, FRAMES))
        finally:
            handlers.remove(handler)

    def undo(self):
        for _ in range(self.random.randint(1, 3)):
            if bpy.ops.ed.undo.poll():
                bpy.ops.ed.undo()

    def redo(self):
        if bpy.ops.ed.redo.poll():
            bpy.ops.ed.redo()

    def load(self):
        bpy.ops.wm.save_as_mainfile(filepath=self.file, check_existing=False)
        self.scene.frame_set(self.random.randint(1, FRAMES))
        bpy.ops.wm.open_mainfile(filepath=self.file, use_scripts=False, load_ui=False)
        assert session.result_of(self.scene) is None, "nothing of the file before is left"
        self.scene.frame_set(self.scene.frame_current)

    def render(self):
        self.scene.frame_set(self.random.randint(1, FRAMES))
        bpy.ops.render.render()

    def other_scene(self):
        """A copy of the scene, with the same objects, goes on."""
        if len(bpy.data.scenes) < 3:
            bpy.context.window.scene = self.scene.copy()
            self.scene.frame_set(self.random.randint(1, FRAMES))

    def back(self):
        """The scene is removed while it is traced; another one goes on."""
        if len(bpy.data.scenes) > 1:
            gone = self.scene
            gone.frame_set(self.random.randint(1, FRAMES))
            bpy.context.window.scene = next(scene for scene in bpy.data.scenes if scene != gone)
            bpy.data.scenes.remove(gone)
            self.scene.frame_set(self.scene.frame_current)

    def check(self):
        scene = self.scene
        bpy.context.view_layer.update()
        depsgraph = bpy.context.evaluated_depsgraph_get()
        reader = SceneReader()
        reading = reader.read(scene, depsgraph)
        if session.result_of(scene) is None and self.done[-1] in (
            "undo",
            "redo",
        ):  # it came to a scene where nothing happened yet
            scene.frame_set(scene.frame_current)
        result = session.result_of(scene)
        where = f"after {len(self.done)} operations, the last of them {self.done[-6:]}"
        if reader.is_empty:  # nothing is tagged
            assert result is None, where
            return
        assert result is not None, where
        known = sessions.shown(scene).reading
        assert known.bodies == reading.bodies, where
        assert known.contact_settings == reading.contact_settings, where
        tracer = Tracer(replace(reading.contact_settings, impacts=False))
        fresh = tracer.step(session.frame_of(scene, reading, continuous=False))
        assert result.number == fresh.number == scene.frame_current, where
        assert result.objects == fresh.objects, where
        assert [item.name for item in result.listeners] == [
            item.name for item in fresh.listeners
        ], where
        assert result.sources[: len(fresh.sources)] == fresh.sources, where
        np.testing.assert_allclose(
            result.amplitudes[: len(fresh.sources)],
            fresh.amplitudes,
            rtol=SAME,
            atol=1e-9,
            err_msg=where,
        )
        assert sessions.shown(scene).result.number == fresh.number, where


@pytest.mark.slow
def test_every_result_is_that_of_a_fresh_trace(seed, tmp_path, pytestconfig):
    stress = Stress(seed, tmp_path)
    for _ in range(pytestconfig.getoption("--stress-operations")):
        stress.step()
        # Else the next operation comes while the frame is being traced.
        if stress.random.random() < 0.6:
            stress.check()
    stress.check()
    assert set(stress.done) == set(WEIGHTS), "every operation was tried"
