"""What Blender says that an evaluation of a scene has changed."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from bpy.types import Action, Armature, Collection, Depsgraph, Mesh, Object, Scene

from ...core.frozen import frozen
from ..blender.arrays import read_array


@frozen(eq=False)
class Evaluation:
    """The changes of an evaluation.

    Attributes:
        objects: that were evaluated, by session id.
        edited: session ids of the meshes, and of the objects whose geometry or rigid body may have
            changed, with the compounds that they are parts of.
        joints: whether a joint may have changed, or a rigid body constraint.
        names_all: whether nothing else has changed, and no object has come or gone.
    """

    objects: Mapping[int, Object]
    edited: frozenset[int]
    joints: bool
    names_all: bool

    @classmethod
    def of(cls, depsgraph: Depsgraph, names_all: bool, moves: bool) -> Evaluation:
        """What the updates of a depsgraph name. ``names_all``: nothing has been evaluated without
        being named. ``moves``: an edit may have moved objects on each other."""
        objects: dict[int, Object] = {}
        edited: set[int] = set()
        joints = False
        of_frame = names_all  # which names the actions that it plays, too
        updates = depsgraph.updates
        kinds = ("is_updated_geometry", "is_updated_transform")
        flags = (read_array(updates, kind, 1, np.bool_)[:, 0].tolist() for kind in kinds)
        for update, is_reshaped, is_moved in zip(updates, *flags, strict=True):
            evaluated = update.id
            changed = evaluated and evaluated.original
            if isinstance(changed, Object):
                objects[changed.session_uid] = changed
                if changed.rigid_body_constraint:
                    joints |= not (is_moved and of_frame)
                elif moves and is_moved and not of_frame:
                    joints |= bool(changed.parent or changed.pose)
                if is_reshaped:
                    edited |= _with_compounds(changed)
                elif not is_moved:  # animation may have hidden it
                    names_all = False
            elif isinstance(changed, Mesh) and is_reshaped:
                edited.add(changed.session_uid)
            elif isinstance(changed, (Action, Armature)):
                joints |= not of_frame
            elif isinstance(changed, (Scene, Collection)):
                names_all = False
        return cls(objects, frozenset(edited), joints, names_all)


def _with_compounds(obj: Object | None) -> set[int]:
    """Session ids of an object and of the compounds that it is a part of."""
    found = set()
    while obj is not None:
        found.add(obj.session_uid)
        above = obj.parent if obj.rigid_body is not None else None
        obj = above if above is not None and above.rigid_body is not None else None
    return found
