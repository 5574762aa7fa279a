"""Pictures, looked at pixel by pixel: the colours where the nodes are, what hides what, and that
nothing is left behind."""

import os
import struct
import subprocess
import sys
import warnings
import zlib

import bpy
import numpy as np
import pytest
from bpy_extras.object_utils import world_to_camera_view
from haptic_tracing.addon.view import overlay
from haptic_tracing.addon.view.annotations import placed_annotations
from haptic_tracing.addon.view.camera import camera_view, picture_scale
from haptic_tracing.addon.view.render_data import SILENT_COLOUR, SOURCE_COLOUR, Options, render_data
from haptic_tracing.pictures import cycles_picture, picture, raster, shown
from haptic_tracing.pictures.png import write_png
from mathutils import Vector

from .conftest import BRIDGE

SIZE, SMALL = (640, 400), (400, 250)


@pytest.fixture
def off_screen():
    """Skips where this Blender can't draw without a window (before 5.2)."""
    if not picture.starts_gpu():
        assert bpy.app.version < (5, 2), (
            "Blender 5.2 on can draw off-screen with Mesa: install libegl1 and libgl1-mesa-dri"
        )
        pytest.skip("before Blender 5.2 nothing can be drawn without a window")


def read_png(path):
    """Pixels of an 8 bit PNG without filters."""
    data = path.read_bytes()
    assert data.startswith(b"\x89PNG\r\n\x1a\n")
    place, body = 8, b""
    while place < len(data):
        (length,), kind = struct.unpack(">I", data[place : place + 4]), data[place + 4 : place + 8]
        content = data[place + 8 : place + 8 + length]
        assert struct.unpack(">I", data[place + 8 + length : place + 12 + length])[0] == zlib.crc32(
            kind + content
        )
        if kind == b"IHDR":
            width, height, depth, colour = struct.unpack(">IIBB", content[:10])
            assert depth == 8
        if kind == b"IDAT":
            body += content
        place += 12 + length
    rows = np.frombuffer(zlib.decompress(body), dtype=np.uint8).reshape(height, -1)
    assert not rows[:, 0].any()
    return rows[:, 1:].reshape(height, width, {2: 3, 6: 4}[colour])


def _pixel(scene, pixels, place, offset=(0, 0)):
    height, width = pixels.shape[:2]
    scene.render.resolution_x, scene.render.resolution_y = width, height
    x, y, _ = world_to_camera_view(scene, scene.camera, Vector(place))
    return pixels[int((1 - y) * height) - offset[1], int(x * width) + offset[0]] / 255


def _node(result, name):
    for node in (*result.sources, *result.listeners):
        if node.name == name:
            return node.position
    raise KeyError(name)


def test_png_is_read_by_blender_as_it_was_written(tmp_path):
    pixels = np.random.default_rng(3).integers(0, 256, (7, 5, 3), dtype=np.uint8)
    write_png(tmp_path / "a.png", pixels)
    assert np.array_equal(read_png(tmp_path / "a.png"), pixels)
    image = bpy.data.images.load(str(tmp_path / "a.png"))
    assert tuple(image.size) == (5, 7)
    values = np.array(image.pixels[:]).reshape(7, 5, 4)[::-1, :, :3]
    assert values * 255 == pytest.approx(pixels, abs=1e-3)


def test_picture_without_a_camera_says_so(scene, bridge, tmp_path):
    scene.camera = None
    with pytest.raises(ValueError, match="has no camera"):
        picture.draw_picture(scene, bridge, tmp_path / "a.png")
    assert not list(tmp_path.iterdir())


@pytest.mark.slow
def test_viewport_picture_shows_the_nodes_in_their_colours(
    off_screen, scene, camera, bridge, tmp_path
):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        picture.draw_picture(scene, bridge, tmp_path / "a.png", SIZE)
    pixels = read_png(tmp_path / "a.png")
    assert pixels.shape == (SIZE[1], SIZE[0], 3)
    data = render_data(bridge, BRIDGE.settings, Options())
    gains = bridge.amplitudes.max(axis=0)
    assert _pixel(scene, pixels, _node(bridge, "truck")) == pytest.approx(SOURCE_COLOUR, abs=0.02)
    for listener, gain in zip(bridge.listeners[:2], gains[:2], strict=True):
        assert _pixel(scene, pixels, listener.position) == pytest.approx(
            data.scale.colour(gain), abs=0.02
        )
    assert _pixel(scene, pixels, _node(bridge, "hermit")) == pytest.approx(SILENT_COLOUR, abs=0.12)
    along = data.paths.position.mean(axis=1)
    expected = data.paths.colour.mean(axis=1)[:, :3]
    found = np.array([_pixel(scene, pixels, place) for place in along])
    assert np.abs(found - expected).max() < 0.06
    background = pixels[2, 2] / 255
    # Most of the picture is the empty scene.
    assert np.abs(pixels / 255 - background).max(axis=2).mean() < 0.2


@pytest.fixture
def wall(scene, camera):
    """A grey wall between the camera and the bridge."""
    mesh = bpy.data.meshes.new("wall")
    mesh.from_pydata([(-9, -2, -9), (9, -2, -9), (9, -2, 9), (-9, -2, 9)], [], [(0, 1, 2, 3)])
    obj = bpy.data.objects.new("wall", mesh)
    scene.collection.objects.link(obj)
    bpy.context.view_layer.update()


@pytest.mark.slow
def test_wall_hides_the_graph_unless_it_is_drawn_in_front(off_screen, scene, camera, wall, bridge):
    scene.haptics.show_labels = False
    in_front = picture.viewport_picture(scene, bridge, SIZE)
    scene.haptics.xray = False
    hidden = picture.viewport_picture(scene, bridge, SIZE)
    place = _node(bridge, "truck")
    wall_colour = _pixel(scene, hidden, (0.5, 0, 0))
    assert _pixel(scene, in_front, place) == pytest.approx(SOURCE_COLOUR, abs=0.02)
    # A ghost of source and path is left: layers of faint opacity.
    assert 0.05 < np.abs(_pixel(scene, hidden, place) - wall_colour).max() < 3 * overlay.HIDDEN


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["PERSP", "ORTHO"])
def test_lines_on_a_surface_are_not_hidden_by_it(off_screen, scene, camera, bridge, kind):
    """The surface passes through the nodes; only what comes towards the viewer wins everywhere."""
    camera.data.type, camera.data.ortho_scale = kind, 5.0
    mesh = bpy.data.meshes.new("sheet")
    mesh.from_pydata([(-9, 0, -9), (9, 0, -9), (9, 0, 9), (-9, 0, 9)], [], [(0, 1, 2, 3)])
    scene.collection.objects.link(bpy.data.objects.new("sheet", mesh))
    bpy.context.view_layer.update()
    scene.haptics.show_labels = False
    in_front = picture.viewport_picture(scene, bridge, SIZE).astype(int)
    scene.haptics.xray = False
    among = picture.viewport_picture(scene, bridge, SIZE).astype(int)
    assert np.abs(in_front - among).max() <= 3


@pytest.mark.slow
def test_lines_that_pass_behind_the_viewer_are_cut_not_turned(off_screen, scene, camera, bridge):
    """From inside the graph: no stroke across the sky."""
    camera.location = (0, -0.1, -0.2)
    camera.rotation_euler = (np.pi / 2, 0, np.pi / 2)  # towards -x; the pier lies behind
    bpy.context.view_layer.update()
    scene.haptics.show_labels = False
    empty = picture.viewport_picture(scene, bridge, SIZE)
    assert np.isfinite(empty).all()
    above = empty[: SIZE[1] // 8].astype(int)
    assert np.abs(above - above[0, 0]).max() <= 12


@pytest.mark.slow
def test_picture_leaves_viewport_and_preferences_as_they_were(off_screen, scene, camera, bridge):
    area = next(area for area in bpy.context.window.screen.areas if area.type == "VIEW_3D")
    space, system = area.spaces.active, bpy.context.preferences.system

    def state():
        shading = {
            key: getattr(space.shading, key)
            for key in ("type", "light", "color_type", "show_shadows", "show_cavity", "cavity_type")
        }
        return (
            shading,
            tuple(space.shading.background_color),
            space.overlay.show_overlays,
            space.show_gizmo,
            system.viewport_aa,
        )

    space.shading.show_cavity, space.shading.cavity_type = False, "SCREEN"
    before = state()
    picture.viewport_picture(scene, bridge, (64, 40))
    assert state() == before
    assert not overlay._drawings


@pytest.mark.slow
def test_painted_labels_and_legend_against_the_gpu(off_screen, scene, camera, bridge):
    """The same annotations by the shader and by the painter for pictures without a GPU."""
    scene.haptics.show_intra = scene.haptics.show_best_paths = False
    by_gpu = picture.viewport_picture(scene, bridge, SIZE).astype(int)
    factor = shown.SMOOTHING
    size, scale = tuple(factor * side for side in SIZE), factor * picture_scale(SIZE)
    view, projection = camera_view(scene, size)
    data = render_data(bridge, BRIDGE.settings, Options(show_intra=False, show_best_paths=False))
    items = placed_annotations(
        data,
        np.array(projection @ view, dtype=np.float64),
        size,
        scale,
        (0.0, 0.0, *size),
    )
    canvas = np.full((size[1], size[0], 3), by_gpu[2, 2] / 255)
    raster.paint(canvas, items, scale)
    by_painter = shown.averaged(np.rint(canvas[::-1] * 255).astype(np.uint8)).astype(int)
    plates = [
        np.s_[SIZE[1] - int(top) : SIZE[1] - int(bottom), int(left) : int(right)]
        for (left, bottom, _), (right, top, _) in items.lines.position[[0, -2, -1]] / factor
    ]
    # The legend and two labels; texts are fitted to the pixels on screen and not here, so their ink
    # is compared.
    for part in plates:
        ink = [
            np.abs(pixels[part] - np.median(by_gpu[part], axis=(0, 1))).sum()
            for pixels in (by_painter, by_gpu)
        ]
        assert ink[0] == pytest.approx(ink[1], rel=0.15)
    bar = np.s_[
        plates[0][0].stop - round(29 * picture_scale(SIZE)),
        plates[0][1].start + 12 : plates[0][1].stop - 12,
    ]
    assert np.abs(by_painter[bar] - by_gpu[bar]).max() <= 4


@pytest.mark.plugins
@pytest.mark.slow
def test_rendered_picture_shows_the_same_and_leaves_the_scene_alone(
    scene, camera, bridge, monkeypatch
):
    monkeypatch.setattr(cycles_picture, "SAMPLES", 4)
    monkeypatch.setattr(cycles_picture, "GRAPH_SAMPLES", 4)
    scene.render.engine, scene.render.resolution_x = "BLENDER_WORKBENCH", 123
    before = {
        kind: len(getattr(bpy.data, kind))
        for kind in ("scenes", "objects", "meshes", "cameras", "curves", "fonts")
    }
    pixels = cycles_picture.rendered_picture(scene, bridge, SIZE)
    assert pixels.shape == (SIZE[1], SIZE[0], 3)
    assert (scene.render.engine, scene.render.resolution_x) == ("BLENDER_WORKBENCH", 123)
    assert {kind: len(getattr(bpy.data, kind)) for kind in before} == before
    assert {image.name for image in bpy.data.images} <= {
        "Render Result"
    }  # Blender makes it and keeps it
    data = render_data(bridge, BRIDGE.settings, Options())
    assert _pixel(scene, pixels, _node(bridge, "truck")) == pytest.approx(SOURCE_COLOUR, abs=0.12)
    found = np.array([_pixel(scene, pixels, place) for place in data.paths.position.mean(axis=1)])
    assert np.abs(found - data.paths.colour.mean(axis=1)[:, :3]).max() < 0.2


@pytest.mark.plugins
@pytest.mark.slow
def test_rendered_graph_is_hidden_unless_it_is_drawn_in_front(
    scene, camera, wall, bridge, monkeypatch
):
    monkeypatch.setattr(cycles_picture, "SAMPLES", 4)
    monkeypatch.setattr(cycles_picture, "GRAPH_SAMPLES", 4)
    scene.haptics.show_labels = scene.haptics.xray = False
    hidden = cycles_picture.rendered_picture(scene, bridge, SMALL)
    assert _pixel(scene, hidden, _node(bridge, "truck")) == pytest.approx(
        _pixel(scene, hidden, (0.5, 0, 0)), abs=0.05
    )
    assert [obj.name for obj in scene.objects if "Haptic" in obj.name] == []


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="EGL is Linux's way to a GPU without a screen")
def test_without_egl_the_gpu_is_left_alone():
    """Blender itself ends with a segmentation fault there."""
    program = (
        "import bpy; from haptic_tracing.pictures import picture; print('starts:', "
        "picture.starts_gpu())"
    )
    nowhere = {"__EGL_VENDOR_LIBRARY_DIRS": "/nonexistent", "LIBGL_DRIVERS_PATH": "/nonexistent"}
    done = subprocess.run(
        [sys.executable, "-c", program],
        env={**os.environ, **nowhere},
        capture_output=True,
        text=True,
        check=True,
    )
    assert "starts: False" in done.stdout
