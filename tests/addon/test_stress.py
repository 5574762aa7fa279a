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
from haptic_tracing.addon.bake.baking import bake_job
from haptic_tracing.addon.scene_reader.reader import SceneReader
from haptic_tracing.addon.session import session, sessions
from haptic_tracing.core.tracer import Tracer

FRAMES = 30
SAME_PLACE = 1e-6
"""Metres: poses of children are corrected by what rounding has changed since the frame before."""
MOST_BOXES = 12
MOST_CORNERS = 64
SAME = 1e-3
"""Relative difference of gains: a contact is found again only where its bodies have moved by more
than 0.01 mm."""


def pytest_generate_tests(metafunc):
    if "seed" in metafunc.fixturenames:
        metafunc.parametrize("seed", range(metafunc.config.getoption("--stress-seeds")))


WEIGHTS = {
    "move": 8, "turn": 3, "material": 4, "source": 4, "tag": 2, "add": 3, "remove": 2, "rename": 2, "animate": 4, "setting": 2,
    "modify": 6, "select": 4, "unseen": 2, "share": 3, "vertex": 3, "rule": 2,
    "parent": 3, "collect": 2, "exclude": 2, "instance": 2, "shape_key": 3, "unit": 1, "join": 2, "edit_mode": 2,
    "bake": 2, "stopped_bake": 2, "take": 2, "delete_bake": 1,
    "jump": 8, "run": 8, "nest": 4, "undo": 6, "redo": 4, "load": 1, "render": 1, "other_scene": 2, "back": 2,
}  # fmt: skip
"""How often each operation comes."""


def dangling():
    """Paths of the add-on's pointers to what is not in the file."""
    there = {
        item.as_pointer()
        for name in ("collections", "materials", "node_groups", "objects", "sounds", "texts")
        for item in getattr(bpy.data, name)
    }
    owners = [*bpy.data.scenes, *bpy.data.objects, *bpy.data.node_groups]
    return [path for owner in owners for path in dangling_in(owner.haptics, owner.name, there)]


def dangling_in(group, path, there):
    found = []
    for item in group.bl_rna.properties:
        if item.identifier == "rna_type" or item.type not in ("POINTER", "COLLECTION"):
            continue
        value, name = getattr(group, item.identifier), f"{path}.{item.identifier}"
        if isinstance(value, bpy.types.ID):
            found += [] if value.as_pointer() in there else [name]
        elif item.type == "COLLECTION":
            for each in value:
                found += dangling_in(each, name, there)
        elif value is not None:
            found += dangling_in(value, name, there)
    return found


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
            (obj for obj in bpy.context.view_layer.objects if obj.type == "MESH"),
            key=lambda obj: obj.name,
        )

    def step(self):
        name = self.random.choices(list(WEIGHTS), list(WEIGHTS.values()))[0]
        self.done.append(name)
        getattr(self, name)()
        assert dangling() == [], f"after {self.done[-6:]}"

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
        self.some_box()  # one is there: no step of undo is stored while tracing is off
        self.scene.haptics.tracing = False
        self.run()
        self.change_modifiers()
        self.run()
        self.scene.haptics.tracing = True
        self.edited()

    def parent(self):
        """A box follows another one, or none any more."""
        box, other = self.some_box(), self.some_box()
        above = other
        while above is not None and above != box:
            above = above.parent
        box.parent = None if above == box else other
        self.edited()

    def collect(self):
        """A box is put into a collection, or taken out of it."""
        group = bpy.data.collections.get("group") or bpy.data.collections.new("group")
        if group.name not in self.scene.collection.children:
            self.scene.collection.children.link(group)
        box = self.some_box()
        if box.name not in group.objects:
            group.objects.link(box)
        elif box.name in self.scene.collection.objects:
            group.objects.unlink(box)
        self.edited()

    def exclude(self):
        """The collection is left out, disabled, hidden, or there again."""
        layer = bpy.context.view_layer.layer_collection.children.get("group")
        if layer is not None:
            name = self.random.choice(("exclude", "hide_viewport"))
            held = self.random.choice((layer, layer.collection)) if name != "exclude" else layer
            setattr(held, name, not getattr(held, name))
        self.edited()

    def instance(self):
        """The collection is shown once more, or no more."""
        shown = bpy.data.objects.get("instance")
        if shown is not None:
            bpy.data.objects.remove(shown)
        elif group := bpy.data.collections.get("group"):
            shown = bpy.data.objects.new("instance", None)
            self.scene.collection.objects.link(shown)
            shown.instance_type, shown.instance_collection = "COLLECTION", group
            shown.location = (0, 0, self.random.choice((0.98, 4.0)))
        self.edited()

    def shape_key(self):
        """A box has a mesh of its own with a shape key, which is moved or animated."""
        box = self.some_box()
        if box.data.shape_keys is None:
            box.data = box.data.copy()
            box.shape_key_add(name="rest")
            for point in box.shape_key_add(name="up").data:
                point.co.z += 0.5
        key = box.data.shape_keys.key_blocks[-1]
        key.value = self.random.choice((0.0, 0.5, 1.0))
        if self.random.random() < 0.3:
            key.keyframe_insert("value", frame=self.random.randint(1, FRAMES))
        self.edited()

    def unit(self):
        self.scene.unit_settings.scale_length = self.random.choice((1.0, 0.5))
        self.edited()

    def join(self):
        box, other = self.some_box(), self.some_box()
        corners = len(box.data.vertices) + len(other.data.vertices)
        if box != other and box.data != other.data and corners <= MOST_CORNERS:
            both = [box, other]
            with bpy.context.temp_override(
                active_object=box, object=box, selected_objects=both, selected_editable_objects=both
            ):
                bpy.ops.object.join()
        self.edited()

    def edit_mode(self):
        box = self.some_box()
        if box.visible_get():
            bpy.context.view_layer.objects.active = box
            bpy.ops.object.mode_set(mode="EDIT")
            bpy.ops.mesh.select_all(action="SELECT")
            bpy.ops.transform.translate(value=(0.01, 0, 0))
            bpy.ops.object.mode_set(mode="OBJECT")
        self.edited()

    def bake(self):
        """As a script does it."""
        self.scene.frame_start = self.random.randint(1, FRAMES)
        self.scene.frame_end = self.scene.frame_start + 2
        try:
            bpy.ops.haptic.bake()
        except RuntimeError as error:
            assert "listener" in str(error) or "can't be traced" in str(error), error

    def stopped_bake(self):
        """Esc, or a closed window, at any step."""
        running = bake_job(self.scene)
        try:
            for _ in range(self.random.randint(0, 5)):
                running.advance(0.0)
        except ValueError as error:
            assert "listener" in str(error) or "can't be traced" in str(error), error
        running.cancel()

    def take(self):
        if bpy.ops.haptic.keep_take.poll():
            bpy.ops.haptic.keep_take()
        takes = self.scene.haptics.bake.takes
        if takes:
            bpy.ops.haptic.play_take(index=self.random.randrange(len(takes)))
        self.edited()

    def delete_bake(self):
        if bpy.ops.haptic.delete_bake.poll():
            bpy.ops.haptic.delete_bake()
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
        self.arrive()

    def redo(self):
        if bpy.ops.ed.redo.poll():
            bpy.ops.ed.redo()
        self.arrive()

    def arrive(self):
        """Undo may come to a scene where nothing has happened yet."""
        if session.result_of(self.scene) is None:
            self.scene.frame_set(self.scene.frame_current)

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
        for ours, theirs in zip(result.sources, fresh.sources, strict=False):
            assert replace(ours, position=theirs.position) == theirs, where
            assert ours.position == pytest.approx(theirs.position, abs=SAME_PLACE), where
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
