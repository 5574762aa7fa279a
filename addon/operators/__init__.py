"""Operators: tag objects, add things, trace, look at problems."""

from __future__ import annotations

import bpy

from . import adding, selection, tagging, tracing

CLASSES = tuple(cls for module in (tagging, adding, tracing, selection) for cls in module.CLASSES)

register, unregister = bpy.utils.register_classes_factory(CLASSES)
