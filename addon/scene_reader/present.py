"""Which view layer of a scene is traced, and which objects are there."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import bpy
import numpy as np
from bpy.types import Collection, Depsgraph, LayerCollection, Object, Scene, ViewLayer
from numpy.typing import NDArray

from ..blender.arrays import read_array
from ..changes.events import file_changed


def traced_layer(scene: Scene) -> ViewLayer:
    """The view layer of a scene that is traced: the context's, else the one that a window shows,
    else the first."""
    context = bpy.context
    if context.scene == scene and context.window is not None and context.view_layer is not None:
        return context.view_layer
    windows = context.window_manager.windows
    shown = (window.view_layer for window in windows if window.scene == scene)
    return next(shown, scene.view_layers[0])


_apart: set[int] = set()
"""Session ids of scenes that were read while a window showed another one."""


def is_shown(scene: Scene) -> bool:
    """Whether all windows show a scene, and always have when it was read: Blender then writes what
    it evaluates to the objects themselves. What it evaluated before is not written later."""
    if any(window.scene != scene for window in bpy.context.window_manager.windows):
        _apart.add(scene.session_uid)
    return scene.session_uid not in _apart


file_changed.subscribe(_apart.clear)


def evaluated_in(objects: Iterable[Object], depsgraph: Depsgraph) -> Iterable[Object]:
    """Objects with the transforms and animated values that they have in a depsgraph."""
    if is_shown(depsgraph.scene):
        return objects
    return [obj.evaluated_get(depsgraph) for obj in objects]


def present_objects(layer: ViewLayer) -> NDArray[np.int32]:
    """Session ids of the objects of a view layer, without those that are disabled in viewports,
    by themselves or with their collections: Blender doesn't move these. It moves disabled rigid
    bodies and what the eye in the outliner hides, which are kept."""
    return present_and_disabled(layer)[0]


def present_and_disabled(layer: ViewLayer) -> tuple[NDArray[np.int32], frozenset[int]]:
    """The `present_objects`, and the session ids of those that are disabled by themselves."""
    objects = layer.objects
    ids = read_array(objects, "session_uid", 1, np.int32)[:, 0]
    disabled = read_array(objects, "hide_viewport", 1, np.bool_)[:, 0]
    alone = frozenset(ids[disabled].tolist())
    enabled = list(_enabled(layer.layer_collection))
    if len(enabled) < 1 + len(layer.layer_collection.collection.children_recursive):
        there = [read_array(each.objects, "session_uid", 1, np.int32)[:, 0] for each in enabled]
        disabled |= ~np.isin(ids, np.concatenate(there))
    if disabled.any():
        moved = np.array([obj.rigid_body is not None for obj in objects])
        return ids[~disabled | moved], alone
    return ids, alone


def _enabled(layer: LayerCollection) -> Iterator[Collection]:
    """The collections below a layer that are not disabled in viewports."""
    if not layer.exclude and not layer.collection.hide_viewport:
        yield layer.collection
        for child in layer.children:
            yield from _enabled(child)
