"""Joints of a scene: between each child whose keys only rotate it, and its parent."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from bpy.types import Object, Scene
from mathutils import Matrix

from ...core.arrays import FloatArray
from ...core.scene.joint import Joint
from ..blender.compatibility import fcurves_of
from ..blender.units import metres_per_unit
from .world_transforms import rigid_transforms


def joints_of(scene: Scene) -> tuple[Joint, ...]:
    """The joints between tagged objects, at rest where a child is not turned. A link that is an
    empty stands for the tagged objects that it carries."""
    metres = metres_per_unit(scene)
    found = []
    for child in scene.objects:
        parent = child.parent
        if parent is None or child.parent_type != "OBJECT" or not _turns(child):
            continue
        at_rest = child.matrix_parent_inverse @ Matrix.LocRotScale(
            child.location, None, child.scale
        )
        scale = Matrix.Diagonal((*(metres * parent.matrix_world.to_scale()), 1.0))
        for one, place in _parts(parent):
            for other, carried in _parts(child):
                placed = scale @ place, scale @ at_rest @ carried
                first, second = (_rigid(matrix) for matrix in placed)
                pivot = np.append((scale @ at_rest).translation, 1.0)
                ends = tuple(np.linalg.solve(pose, pivot)[:3] for pose in (first, second))
                turn = Matrix((first[:3, :3].T @ second[:3, :3]).tolist()).to_quaternion()
                positions = tuple(_rounded(end) for end in ends)
                names = one.name_full, other.name_full
                found.append(Joint(names, positions, _rounded(np.array(turn))))
    return tuple(found)


def _turns(obj: Object) -> bool:
    """Whether curves turn an object, but move it nowhere."""
    paths = {curve.data_path for curve in fcurves_of(obj)}
    return "location" not in paths and any(path.startswith("rotation") for path in paths)


def _parts(link: Object) -> Iterator[tuple[Object, Matrix]]:
    """The tagged objects of a link, each with its matrix in the space of the link."""
    if link.haptics.enabled:
        yield link, Matrix()
    elif link.type == "EMPTY":
        for part in link.children:
            if part.haptics.enabled and part.parent_type == "OBJECT":
                yield part, part.matrix_parent_inverse @ part.matrix_basis


def _rigid(matrix: Matrix) -> FloatArray:
    return rigid_transforms(np.array(matrix.transposed(), dtype=np.float32).reshape(1, 16))[0][0]


def _rounded(values: FloatArray) -> tuple[float, ...]:
    return tuple(float(f"{value:.6f}") + 0.0 for value in values.tolist())
