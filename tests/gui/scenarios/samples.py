"""Each sample scene frames itself and shows what is felt, without a step or a click more."""

import time

import bpy


def steps(window):
    sessions, samples = (
        window.module("addon.session.sessions"),
        window.module("sample_scenes").SAMPLES,
    )
    window.open_only("HAPTIC_PT_scene")
    yield from window.show_sidebar()
    took, shown = {}, []
    window.module("sample_scenes.staging").show = shown.append
    for name in samples:
        shown.clear()
        window.view.spaces.active.region_3d.view_perspective = "PERSP"
        begun = time.monotonic()
        with window.context():
            bpy.ops.haptic.add_sample(sample=name)
        took[name] = time.monotonic() - begun
        scene = bpy.context.window.scene
        yield from window.wait_until(lambda scene=scene: sessions.shown(scene) is not None)
        framed = (
            window.view.spaces.active.region_3d.view_perspective == "CAMERA"
            and scene.camera is not None
        )
        window.seen[f"{name} shows progress"] = (
            len(shown) > 30 and shown == sorted(shown) and shown[-1] > 0.9
        )
        window.seen[f"{name} frames itself"] = scene.name == samples[name].title and framed
        window.seen[f"{name} is traced"] = sessions.shown(scene) is not None
        if name in ("hammer_nail", "dishwasher_kitchen", "rails", "pile"):
            yield from window.screenshot(name)
    print("seconds", {name: round(seconds, 1) for name, seconds in took.items()})
