"""Objects by their full names, which end with the library of linked ones."""

from __future__ import annotations

import bpy
from bpy.types import ID, Object


def object_named(full_name: str) -> Object | None:
    """The object of a full name."""
    name, _, library = full_name.removesuffix("]").rpartition(" [")
    linked = bpy.data.libraries.get(library) if full_name.endswith("]") else None
    found = None if linked is None else bpy.data.objects.get((name, linked.filepath))
    return found or bpy.data.objects.get(full_name)


def object_meant(name: str, owner: ID) -> Object | None:
    """The object that a property of ``owner`` names, see `name_for`."""
    library = owner.library
    found = None if library is None else bpy.data.objects.get((name, library.filepath))
    return found or object_named(name)


def name_for(obj: Object, owner: ID) -> str:
    """The name by which a property of ``owner`` means an object: without the library that it was
    chosen in."""
    return obj.name if obj.library == owner.library else obj.name_full
