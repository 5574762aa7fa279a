"""Operators: tag objects, add things, trace, look at problems."""

from __future__ import annotations

import bpy

from . import adding, selection, tagging, tracing

CLASSES = tuple(cls for module in (tagging, adding, tracing, selection) for cls in module.CLASSES)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
