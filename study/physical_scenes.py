"""The ten listeners of three samples with the paper's function and with measured materials, whose
contacts pass what both bodies can take; and the twelve of a new body, measured and felt all over.

``python -m haptic_tracing.study.physical_scenes`` prints the tables of `docs/physical.md`.
"""

from __future__ import annotations

from importlib import import_module

import bpy
import haptic_tracing
import numpy as np
from bpy.types import Object, Scene
from mathutils import Vector

from ..addon.authoring import materials as library
from ..addon.session import session
from ..core.perception import sensation_level
from ..core.render.history import still_samples
from ..core.scene.body import DEFAULT_LISTENERS
from ..sample_scenes.avatar import Hand, Posture, build_avatar, seated, standing

SAMPLES = (("jackhammer_bench", 3), ("hammer_nail", 20), ("mine_ride", 2638))
"""Module and frame: the jackhammer at work, the blow on the nail, the cart that rumbles."""
WAYS = ("paper", "physical")
BODIES: dict[str, tuple[float, float, float] | Posture] = {
    "one mesh stands on the floor": (0.5, 0.3, 1.75),
    "parts stand on the floor": standing(Hand(Vector((0.3, -0.45, 1.0)), Vector((0.0, -1.0, 0.0)))),
    "one mesh holds a tool": (0.5, 0.3, 1.75),
    "parts hold a tool": standing(Hand(Vector((0.3, -0.45, 1.0)), Vector((0.0, -1.0, 0.0)))),
    "parts sit on what shakes": seated(0.45, 0.1),
}
"""Cases of new bodies: the size of a block [m], or the posture of a mannequin."""
SHAKERS = {
    "one mesh holds a tool": (0.289, 0, 0.84),
    "parts hold a tool": (0.3, -0.45, 0.851),
    "parts sit on what shakes": (0, -0.13, 0.3005),
}
"""Where the shaker touches the body; else it stands on the floor, a metre away."""
WAYS_OF_BODIES = {"MEASURED": "measured", "FELT_ALL_OVER": "felt all over"}
"""The choices of bodies, and what the table calls them."""
PITCHES = (30, 80, 150, 250)
"""Frequencies [Hz] of the shaker of full amplitude."""


def levels(module: str, frame: int) -> tuple[list[str], np.ndarray]:
    """Names of the listeners (l,), and their levels [dB of full scale] (l, ways) during a second of
    the sources as they are in a frame."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.context.scene
    import_module(f"haptic_tracing.sample_scenes.{module}").build(scene)
    columns: list[np.ndarray] = []
    names: list[str] = []
    for way in WAYS:
        make(scene, way)
        for number in range(frame - 2, frame + 1):
            scene.frame_set(number)
            bpy.context.view_layer.update()
            result = session.result_of(scene)
        assert result is not None
        names = [item.name for item in result.listeners]
        with np.errstate(divide="ignore"):
            columns.append(10 * np.log10((still_samples(result, 1.0) ** 2).mean(axis=1)))
    return names, np.stack(columns, axis=1)


def make(scene: Scene, way: str) -> None:
    """Change a sample from the previous one of `WAYS` to this one."""
    if way == WAYS[1]:
        library.make_physical(
            [obj for obj in scene.objects if obj.haptics.enabled and not obj.haptics.medium], False
        )


def body_levels(case: str) -> np.ndarray:
    """Decibels above the threshold of feeling (2, f, 12) at the twelve listeners of a new body at
    each of `PITCHES`, by `WAYS_OF_BODIES`. The shaker stands a metre away on the floor, or is
    touched."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene, posture = bpy.context.scene, BODIES[case]
    _block("Concrete Floor", (6, 6, 0.2), (0, 0, -0.1))
    bpy.ops.haptic.make_objects(physics=True)
    if isinstance(posture, tuple):
        _block("Body", posture, (0, 0, posture[2] / 2 - 0.001))
        bpy.ops.haptic.add_default_listeners()
    else:
        build_avatar(scene, posture, listening=DEFAULT_LISTENERS)
    shaker = _block(
        "Steel Shaker",
        (0.24, 0.24, 0.3) if "sit" in case else (0.08, 0.12, 0.3),
        SHAKERS.get(case, (1, 0, 0.149)),
    )
    bpy.ops.haptic.add_source(signal="SINE")
    bpy.ops.haptic.set_model()
    found = []
    for body in WAYS_OF_BODIES:
        bpy.ops.haptic.set_bodies(body=body)
        for pitch in PITCHES:
            shaker.haptics.source.frequency = pitch
            scene.frame_set(scene.frame_current + 1)
            bpy.context.view_layer.update()
            result = session.result_of(scene)
            assert result is not None
            found.append(sensation_level(still_samples(result, 1.0), result.sample_rate))
    return np.array(found).reshape(len(WAYS_OF_BODIES), len(PITCHES), -1)


def _block(
    name: str, size: tuple[float, float, float], place: tuple[float, float, float]
) -> Object:
    """A block, which is the active and only selected object."""
    bpy.ops.mesh.primitive_cube_add(size=1, location=place)
    block = bpy.context.object
    assert block is not None
    block.name, block.scale = name, size
    bpy.ops.object.transform_apply(location=False, rotation=False, scale=True)
    bpy.context.view_layer.update()
    return block


def body_rows() -> list[str]:
    """The table of new bodies: how many of twelve feel it at each of `PITCHES`, and the strongest
    there."""
    head = " | ".join(f"{way}, {pitch} Hz" for way in WAYS_OF_BODIES.values() for pitch in PITCHES)
    rows = [f"| a new body | {head} |", f"|---|{'---|' * 2 * len(PITCHES)}"]
    for case in BODIES:
        cells = (
            f"{(level > 0).sum()} ({level.max():+.0f} dB)"
            for level in body_levels(case).reshape(2 * len(PITCHES), -1)
        )
        rows.append(f"| {case} | {' | '.join(cells)} |")
    return rows


def main() -> None:
    haptic_tracing.register()
    for module, frame in SAMPLES:
        names, table = levels(module, frame)
        print(f"\n| {module}, frame {frame} | {' | '.join(WAYS)} |\n|---|{'---|' * len(WAYS)}")
        with np.errstate(invalid="ignore"):
            rows = [
                *zip(names, table, strict=True),
                ("strongest to weakest", table.max(axis=0) - table.min(axis=0)),
            ]
        for name, row in rows:
            cells = (f"{value:.1f}" if np.isfinite(value) else "silent" for value in row)
            print(f"| {name} | {' | '.join(cells)} |")
    print("\n" + "\n".join(body_rows()))


if __name__ == "__main__":
    main()
