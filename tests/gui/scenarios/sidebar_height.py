"""How tall the sidebar is: of a new scene, of a sample scene with an object of each role selected,
and of a scene with many of everything; and that nothing in it moves while the timeline plays."""

import bpy
import numpy as np

NEW, ANY = 900, 1300  # pixels
MANY = 30


def height(window, area):
    """Pixels from the top of the panels to their end: how far the sidebar of a low ``area`` can be
    scrolled."""
    region = next(region for region in area.regions if region.type == "UI")
    found = []
    for scroll in (bpy.ops.view2d.scroll_down, bpy.ops.view2d.scroll_up):
        with bpy.context.temp_override(window=window.window, area=area, region=region):
            for _ in range(100):
                scroll(deltay=400)
        yield 0.3
        found.append(-region.view2d.region_to_view(0, 0)[1])
    return found[0]


def select(obj):
    bpy.context.view_layer.objects.active = obj


def crowd():
    """A scene with many sources and listeners, all roles on the selected object, and a problem."""
    scene = bpy.data.scenes.new("Crowd")
    bpy.context.window.scene = scene
    bpy.ops.mesh.primitive_cube_add(size=1)
    ground = bpy.context.object
    ground.name = "Ground of the whole crowd, with a name that no panel has room for"
    ground.haptics.enabled = True
    for number in range(MANY):
        for role in ("source", "listener"):
            empty = bpy.data.objects.new(f"{role} {number}", None)
            scene.collection.objects.link(empty)
            empty.parent = ground
            getattr(empty.haptics, role).enabled = True
    lost = bpy.data.objects.new("lost", None)
    scene.collection.objects.link(lost)
    lost.haptics.source.enabled = True
    ground.haptics.source.enabled = ground.haptics.listener.enabled = True
    select(ground)
    scene.frame_set(1)
    return scene


def output_panel(window, name):
    """The lowest 150 pixels of the sidebar of a screenshot that are not empty: the last panel."""
    image = bpy.data.images.load(str(window.folder / f"{name}.png"))
    width, tall = image.size
    values = np.empty(width * tall * 4, dtype=np.float32)
    image.pixels.foreach_get(values)
    bpy.data.images.remove(image)
    region = window.region("UI")
    left = region.x + region.width // 10
    shown = values.reshape(tall, width, 4)[
        region.y : region.y + region.height, left : region.x + region.width * 8 // 10, :3
    ]
    first = int((np.ptp(shown, axis=1).max(axis=1) > 0.1).argmax())
    return first, shown[first : first + 150]


def _shift(before, now):
    """Pixels by which the panel has moved, or whether it looks otherwise. What is behind the sidebar
    shines through by a 255th."""
    return now[0] - before[0] or bool((np.abs(now[1] - before[1]) > 0.02).any())


def steps(window):
    yield from window.show_sidebar()
    yield from window.screenshot("new")
    samples = window.module("sample_scenes")
    scene = samples.build_sample("hammer_nail")
    window.window.scene = scene
    scene.frame_set(scene.frame_start)
    before = None
    for _ in range(20):  # panels glide to their places
        yield 2.0
        yield from window.screenshot("still")
        earlier, before = before, output_panel(window, "still")
        if earlier is not None and _shift(earlier, before) == 0:
            break
    bpy.ops.screen.animation_play()
    moved = []
    for number in range(3):
        yield 0.7
        yield from window.screenshot(f"playing-{number}")
        moved.append(_shift(before, output_panel(window, f"playing-{number}")))
    bpy.ops.screen.animation_cancel(restore_frame=False)
    window.seen[f"nothing moves while the timeline plays, not {moved}"] = not any(moved)

    with window.context():
        bpy.ops.screen.area_split(direction="HORIZONTAL", factor=0.3)
    yield 1.0
    low = min(
        (area for area in window.window.screen.areas if area.type == "VIEW_3D"),
        key=lambda area: area.height,
    )
    low.spaces.active.show_region_ui = True
    yield 1.0
    next(r for r in low.regions if r.type == "UI").active_panel_category = "Haptics"
    window.window.scene = bpy.data.scenes["Scene"]
    yield 1.0
    found = yield from height(window, low)
    window.seen[f"a new scene: {found:.0f} pixels"] = 0 < found <= NEW

    greatest = (0.0, "")
    scene = samples.build_sample("jackhammer_bench")
    window.window.scene = scene
    scene.frame_set(scene.frame_start + 12)
    yield 1.0
    roles = {
        (obj.haptics.enabled, obj.haptics.source.enabled, obj.haptics.listener.enabled): obj
        for obj in scene.objects
    }
    for obj in roles.values():
        select(obj)
        yield 0.3
        found = yield from height(window, low)
        greatest = max(greatest, (found, obj.name))
    window.seen[f"a sample: at most {greatest[0]:.0f} pixels ({greatest[1]})"] = (
        0 < greatest[0] <= ANY
    )
    crowd()
    yield 2.0
    found = yield from height(window, low)
    window.seen[f"many of everything: {found:.0f} pixels"] = 0 < found <= ANY
    yield from window.screenshot("crowd")
