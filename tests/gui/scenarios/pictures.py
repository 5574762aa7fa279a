"""The picture in a panel is that of the active object: choosing another one replaces it, and
choosing the first one again brings its own back."""

import bpy
import numpy as np


def _difference(window, first, second):
    """The number of pixels of the panel's picture, between its frame lines, that differ clearly
    between two screenshots."""
    pixels = []
    for name in (first, second):
        image = bpy.data.images.load(str(window.folder / f"{name}.png"))
        width, height = image.size
        values = np.empty(width * height * 4, dtype=np.float32)
        image.pixels.foreach_get(values)
        _, region = window.panels()
        pixels.append(
            values.reshape(height, width, 4)[
                region.y : region.y + region.height, region.x : region.x + region.width, :3
            ]
        )
        bpy.data.images.remove(image)
    return int((np.abs(pixels[0] - pixels[1]).max(axis=2) > 0.1).sum())


def steps(window):
    for obj in list(bpy.context.scene.objects):
        bpy.data.objects.remove(obj)
    window.open_only("HAPTIC_PT_object_settings", "HAPTIC_PT_gain", "HAPTIC_PT_object")
    cubes = {}
    for name, loss in (
        ("A", 0.2),
        ("B", 0.95),
        ("C", 0.2),
    ):  # A and C look alike but for their names
        bpy.ops.mesh.primitive_cube_add(size=1)
        cubes[name] = bpy.context.object
        cubes[name].name, cubes[name].haptics.enabled, cubes[name].haptics.kappa = (
            f"Cube {name}",
            True,
            loss,
        )
    yield from window.show_sidebar()
    yield from window.show_properties("OBJECT")
    for number, name in enumerate("ABCBA"):
        bpy.context.view_layer.objects.active = cubes[name]
        yield 1.5
        yield from window.scroll_sidebar(12)  # objects have more or fewer lines above the picture
        yield from window.screenshot(f"gain-{number}-{name}")
    # A picture has some 10,000 pixels, a curve some hundreds; the letter in the name has about ten.
    compared = {"gain-0-A": "gain-4-A", "gain-1-B": "gain-3-B"}
    window.seen["each object has the picture that it had"] = all(
        _difference(window, *pair) < 30 for pair in compared.items()
    )
    window.seen["another object has another picture"] = all(
        _difference(window, "gain-1-B", other) > 300
        for other in ("gain-0-A", "gain-2-C", "gain-4-A")
    )
    window.seen["alike objects have alike pictures"] = (
        _difference(window, "gain-0-A", "gain-2-C") < 60
    )
