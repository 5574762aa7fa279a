"""Objects by their full names, which end with the library of linked ones."""

from __future__ import annotations

import bpy
from bpy.types import Object


def object_named(full_name: str) -> Object | None:
    """The object of a full name."""
    name, _, library = full_name.removesuffix("]").rpartition(" [")
    linked = bpy.data.libraries.get(library) if full_name.endswith("]") else None
    found = None if linked is None else bpy.data.objects.get((name, linked.filepath))
    return found or bpy.data.objects.get(full_name)
