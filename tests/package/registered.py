"""What is registered in the running Blender, as plain names, so that two moments can be compared.
Runs inside Blender."""

import gc
import threading
import types
from collections import Counter

import bpy

DRAW_STAGES = {"PRE_VIEW", "POST_VIEW", "POST_PIXEL", "BACKDROP"}


def _name(function) -> str:
    return f"{getattr(function, '__module__', '?')}.{getattr(function, '__qualname__', function)}"


def _handlers() -> list[str]:
    lists = {name: getattr(bpy.app.handlers, name) for name in dir(bpy.app.handlers)}
    return [
        f"{name}: {_name(function)}"
        for name, value in lists.items()
        if isinstance(value, list)
        for function in value
    ]


def _timers() -> list[str]:
    # Blender lists no timers, but answers for a function whether it is one.
    callables = (types.FunctionType, types.MethodType)
    found = [
        thing
        for thing in gc.get_objects()
        if isinstance(thing, callables) and bpy.app.timers.is_registered(thing)
    ]
    return [_name(function) for function in found]


def _draw_handlers() -> list[str]:
    # Nor does it list draw handlers; each keeps the arguments it was added with: (space type,
    # function, arguments, region, stage).
    tuples = (thing for thing in gc.get_objects() if type(thing) is tuple and len(thing) in (5, 6))
    return [
        _name(thing[1])
        for thing in tuples
        if callable(thing[1]) and isinstance(thing[-1], str) and thing[-1] in DRAW_STAGES
    ]


def _properties() -> list[str]:
    owners = ((name, getattr(bpy.types, name)) for name in dir(bpy.types))
    return [
        f"{name}.{key}"
        for name, owner in owners
        if hasattr(owner, "bl_rna")
        for key in owner.bl_rna.properties.keys()  # noqa: SIM118
    ]


def _menu_entries() -> list[str]:
    """Without Blender's own: the first entry that is appended to a menu makes Blender list its own
    draw function, for good."""
    draws = ((name, getattr(getattr(bpy.types, name), "draw", None)) for name in dir(bpy.types))
    entries = (
        (name, function) for name, draw in draws for function in getattr(draw, "_draw_funcs", ())
    )
    return [
        f"{name}: {_name(function)}" for name, function in entries if not _is_blenders(function)
    ]


def _is_blenders(function: object) -> bool:
    return getattr(function, "__module__", "").split(".")[0] == "bl_ui"


def _keymap_items() -> list[str]:
    configuration = bpy.context.window_manager.keyconfigs.addon  # None in the background
    return [
        f"{keymap.name}: {item.idname}"
        for keymap in (configuration.keymaps if configuration else ())
        for item in keymap.keymap_items
    ]


def registered() -> dict[str, list[str]]:
    """Names by kind, sorted; something registered twice stands twice."""
    gc.collect()
    kinds = {
        "handlers": _handlers(),
        "timers": _timers(),
        "draw handlers": _draw_handlers(),
        "classes": list(dir(bpy.types)),
        "properties": _properties(),
        "menu entries": _menu_entries(),
        "keymap items": _keymap_items(),
        "threads": [thread.name for thread in threading.enumerate()],
        "add-ons": [addon.module for addon in bpy.context.preferences.addons],
    }
    return {kind: sorted(names) for kind, names in kinds.items()}


def difference(before: dict[str, list[str]], after: dict[str, list[str]]) -> dict[str, list[str]]:
    """What `after` has more (+) or fewer (-) of than `before`; empty where they agree."""
    changes = {}
    for kind in before:
        more, fewer = Counter(after[kind]), Counter(before[kind])
        changes[kind] = sorted(
            [f"+ {name}" for name in (more - fewer).elements()]
            + [f"- {name}" for name in (fewer - more).elements()]
        )
    return {kind: lines for kind, lines in changes.items() if lines}
