"""The scene's camera as a viewpoint of pictures."""

from __future__ import annotations

from bpy.types import Scene
from mathutils import Matrix


def camera_view(scene: Scene, size: tuple[int, int]) -> tuple[Matrix, Matrix]:
    """World to camera, and camera to clip space, of the scene's current camera, for a picture of
    ``size`` pixels."""
    view_layer = scene.view_layers[0]
    view_layer.update()
    assert scene.camera is not None
    camera = scene.camera.evaluated_get(view_layer.depsgraph)
    view = camera.matrix_world.normalized().inverted()
    return view, camera.calc_matrix_camera(view_layer.depsgraph, x=size[0], y=size[1])


def picture_scale(size: tuple[int, int]) -> float:
    """Pixels per point of a picture: 1 at a height of 700, so that labels stay legible when it is
    scaled down."""
    return max(0.75, size[1] / 700)
