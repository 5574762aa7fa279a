"""``--set PATH=VALUE``: properties of an open Blender file by their paths, as the Info editor and
tooltips name them."""

from __future__ import annotations

from typing import Any

import bpy
from bpy.types import Scene


def assign(scene: Scene, setting: str) -> None:
    """Set one property.

    Args:
        scene: The scene for paths that begin with ``scene``; other paths begin at ``bpy.data``,
            such as ``objects["Bench"].haptics.kappa``.
        setting: ``PATH=VALUE``. A path is looked up, never executed.

    Raises:
        ValueError: the path does not exist, the value has the wrong type or is out of range, or the
            property is animated or read-only.
    """
    path, equals, text = setting.partition("=")
    if not equals:
        raise ValueError(f"--set {setting}: expected PATH=VALUE")
    root, inside = (
        (scene, path.removeprefix("scene.")) if path.startswith("scene.") else (bpy.data, path)
    )
    holder, dot, name = inside.rpartition(".")
    try:
        owner: Any = root.path_resolve(holder) if dot else root
    except ValueError:
        owner = None
    known = getattr(owner, "bl_rna", None)
    described = known.properties.get(name) if known is not None else None
    if described is None:
        raise ValueError(f"--set {setting}: there is no {path}")
    value = _parsed(setting, described, text)
    try:
        setattr(owner, name, value)
    except (AttributeError, TypeError, ValueError) as error:
        raise ValueError(f"--set {setting}: {error}") from None
    wanted = getattr(owner, name)
    scene.frame_set(scene.frame_current)
    if getattr(owner, name) != wanted:
        raise ValueError(f"--set {setting}: {path} is animated")


def _parsed(setting: str, described: Any, text: str) -> bool | int | float | str:
    """``text`` as a value of the property ``described``."""
    numbers: dict[str, type[int] | type[float]] = {"INT": int, "FLOAT": float}
    single = described.type in ("BOOLEAN", "STRING", "ENUM", *numbers) and not getattr(
        described, "is_array", False
    )
    if described.is_readonly or not single:
        raise ValueError(f"--set {setting}: only single values that can be edited can be set")
    if described.type == "BOOLEAN":
        if text.lower() not in ("true", "false"):
            raise ValueError(f"--set {setting}: must be true or false")
        return text.lower() == "true"
    if described.type in ("STRING", "ENUM"):
        return text
    try:
        value = numbers[described.type](text)
    except ValueError:
        raise ValueError(f"--set {setting}: must be a number") from None
    if not described.hard_min <= value <= described.hard_max:
        raise ValueError(
            f"--set {setting}: must be from {described.hard_min:g} to {described.hard_max:g}"
        )
    return value
