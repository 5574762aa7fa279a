"""Instances of collections and of geometry nodes, and those scattered over meshes, as objects of
their own.

An instance is haptic if the object that it shows is, else if its instancer is, with the properties
of that one.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import NamedTuple

import numpy as np
from bpy.types import Depsgraph, Object
from numpy.typing import NDArray

from ...core.frozen import frozen
from ..blender.arrays import read_array
from ..blender.units import metres_per_unit
from .world_transforms import in_metres

_UNUSED = 2**31 - 1
"""Number in the rest of a persistent id."""


@frozen
class Instances:
    """The haptic instances of a scene: ``places`` (n,) among all of a depsgraph, whose persistent
    ids are ``identity`` (m, 8), and world ``matrices`` (n, 16) in metres, column by column.
    ``instancers`` and ``shown``: session ids of their objects."""

    identity: NDArray[np.int32]
    places: NDArray[np.int64]
    matrices: NDArray[np.float32]
    instancers: frozenset[int] = frozenset()
    shown: frozenset[int] = frozenset()

    def moved(self, depsgraph: Depsgraph) -> NDArray[np.float32] | None:
        """Where the same instances are now, None if there are others."""
        everything = depsgraph.object_instances
        if not np.array_equal(read_array(everything, "persistent_id", 8, np.int32), self.identity):
            return None
        return all_matrices(depsgraph)[self.places]


NONE = Instances(
    np.zeros((0, 8), dtype=np.int32), np.zeros(0, dtype=np.int64), np.zeros((0, 16), np.float32)
)


class HapticInstance(NamedTuple):
    """A haptic instance: its ``place`` among all, its name, the object ``owner`` whose properties
    it has, its instancer, and the evaluated object that it shows, which is valid until the next one
    is found."""

    place: int
    name: str
    owner: Object
    instancer: Object
    shown: Object


def all_matrices(depsgraph: Depsgraph) -> NDArray[np.float32]:
    """World matrices (m, 16) of all instances of a depsgraph in metres, column by column."""
    matrices = read_array(depsgraph.object_instances, "matrix_world", 16)
    return in_metres(matrices, metres_per_unit(depsgraph.scene))


def haptic_instances(depsgraph: Depsgraph) -> Iterator[HapticInstance]:
    """The haptic instances, one after the other."""
    for place, instance in enumerate(depsgraph.object_instances):
        if not instance.is_instance or instance.parent is None or instance.object is None:
            continue
        shown, instancer = instance.object.original, instance.parent.original
        assert shown is not None and instancer is not None
        if shown == instancer and instance.persistent_id[1] == _UNUSED:
            continue  # its own mesh, as Blender has that of curves, texts and metaballs
        owner = next((obj for obj in (shown, instancer) if obj.haptics.enabled), None)
        if owner is not None:
            number = ".".join(str(k) for k in reversed(instance.persistent_id) if k != _UNUSED)
            name = f"{instancer.name_full}: {shown.name_full} {number}"
            yield HapticInstance(place, name, owner, instancer, instance.object)


def instanced_collections(depsgraph: Depsgraph) -> Iterator[tuple[Object, list[Object]]]:
    """The instances of collections, and the objects that each shows."""
    for obj in depsgraph.view_layer.objects:
        if obj.instance_type == "COLLECTION" and obj.instance_collection is not None:
            yield obj, with_instanced([obj])[1:]


def with_instanced(objects: Iterable[Object]) -> list[Object]:
    """Objects, followed by those of the collections that they instance, at any depth."""
    found = list(dict.fromkeys(objects))
    known = set(found)
    for obj in found:
        if obj.instance_collection is not None:
            shown = [each for each in obj.instance_collection.all_objects if each not in known]
            found += shown
            known.update(shown)
    return found
