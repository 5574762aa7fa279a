"""Each visible setting is set in a sample scene, or its declaration says who changes it: ``reasons``
of its property group, by name. And how many settings and operators there are.
"""

from __future__ import annotations

from collections.abc import Iterator
from fnmatch import fnmatch
from inspect import get_annotations
from typing import Any

import bpy
import pytest
from haptic_tracing.sample_scenes import SAMPLES

MOST_SETTINGS, MOST_OPERATORS = 132, 52


def kinds_of(group: Any) -> Iterator[tuple[type, Any]]:
    """Pairs of a property group's class and its RNA, of a group and of all groups in it."""
    yield bpy.types.PropertyGroup.bl_rna_get_subclass_py(group.identifier), group
    for item in group.properties:
        inner = getattr(item, "fixed_type", None)
        if inner is not None and inner.identifier.startswith("Haptic"):
            yield from kinds_of(inner)


def is_setting(item: Any) -> bool:
    inner = getattr(item, "fixed_type", None)
    is_group = inner is not None and inner.identifier.startswith("Haptic")
    return not is_group and not item.is_hidden and item.identifier not in ("rna_type", "name")


def settings() -> set[tuple[type, str]]:
    """The visible properties of scenes and objects: the class that declares each, and its name."""
    return {
        (cls, item.identifier)
        for owner in (bpy.types.Scene, bpy.types.Object)
        for cls, group in kinds_of(owner.bl_rna.properties["haptics"].fixed_type)
        for item in group.properties
        if is_setting(item)
    }


def declaring(cls: type, name: str) -> type:
    """The class or mixin that declares a property first."""
    return next(c for c in reversed(cls.__mro__) if name in get_annotations(c))


def plain(value: Any) -> Any:
    return tuple(value) if hasattr(value, "__len__") and not isinstance(value, str) else value


def changed(group: Any) -> Iterator[tuple[type, str]]:
    """What has another value than its default in a group and in all groups in it."""
    for item in group.bl_rna.properties:
        if item.type == "COLLECTION":
            for inner in getattr(group, item.identifier):
                yield from changed(inner)
        elif item.type == "POINTER":
            value = getattr(group, item.identifier)
            if not is_setting(item) and item.identifier != "rna_type" and value is not None:
                yield from changed(value)
            elif value is not None:
                yield type(group), item.identifier
        elif group.is_property_set(item.identifier):
            default = item.default_array if getattr(item, "is_array", False) else item.default
            if plain(getattr(group, item.identifier)) != plain(default):
                yield type(group), item.identifier


def reason_of(cls: type, name: str) -> str:
    """Who changes a setting, "" if its declaration does not say."""
    return next(
        (
            why
            for c in cls.__mro__
            for pattern, why in c.__dict__.get("reasons", {}).items()
            if fnmatch(name, pattern)
        ),
        "",
    )


@pytest.mark.slow
def test_every_visible_setting_is_set_in_a_sample_or_says_who_changes_it():
    found = set()
    for sample in SAMPLES.values():
        bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
        sample.build(bpy.context.scene)
        found |= set(changed(bpy.context.scene.haptics))
        for obj in bpy.data.objects:
            found |= set(changed(obj.haptics))
    shown = {(declaring(*one), one[1]) for one in found if one in settings()}
    assert len(shown) > 40
    unexplained = {
        f"{cls.__name__}.{name}"
        for cls, name in settings()
        if (declaring(cls, name), name) not in shown and not reason_of(cls, name)
    }
    assert not unexplained, "set them in a sample, or let their value be the behaviour"


def test_reasons_are_of_settings_that_there_are():
    known = settings()
    for cls in {cls for cls, _ in known}:
        for base in cls.__mro__:
            for pattern in base.__dict__.get("reasons", {}):
                assert any(c is cls and fnmatch(name, pattern) for c, name in known), (cls, pattern)


def test_there_are_no_more_settings_and_operators_than_before():
    assert len(settings()) <= MOST_SETTINGS
    stack, found = [bpy.types.Operator], set()
    while stack:
        cls = stack.pop()
        stack += cls.__subclasses__()
        if cls.__module__.startswith("haptic_tracing.") and getattr(cls, "is_registered", False):
            found.add(cls.bl_idname)
    assert len(found) <= MOST_OPERATORS, sorted(found)
