"""The ten listeners of three samples with the paper's function, with measured materials, and with these and contacts by impedance.

``python -m haptic_tracing.study.physical_scenes`` prints the tables of `docs/functions.md`.
"""

from __future__ import annotations

from importlib import import_module

import bpy
import haptic_tracing
import numpy as np
from bpy.types import Scene

from ..addon.authoring import materials as library
from ..addon.session import session
from ..core.render.history import still_samples

SAMPLES = (("jackhammer_bench", 3), ("hammer_nail", 20), ("mine_ride", 2638))
"""Module and frame: the jackhammer at work, the blow on the nail, the cart that rumbles."""
WAYS = ("paper", "physical", "physical, impedance")


def levels(module: str, frame: int) -> tuple[list[str], np.ndarray]:
    """Names of the listeners (l,), and their levels [dB of full scale] (l, ways) during a second of the sources as they are in a frame."""
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
    """Bring a sample from the way before to this one of `WAYS`."""
    if way == WAYS[1]:
        library.make_physical([obj for obj in scene.objects if obj.haptics.enabled and not obj.haptics.medium], False)
    elif way == WAYS[2]:
        rule = scene.haptics.transmission_table.items.add()
        rule.first_kind = rule.second_kind = "ANY"
        rule.function = "impedance"


def main() -> None:
    haptic_tracing.register()
    for module, frame in SAMPLES:
        names, table = levels(module, frame)
        print(f"\n| {module}, frame {frame} | {' | '.join(WAYS)} |\n|---|{'---|' * len(WAYS)}")
        with np.errstate(invalid="ignore"):
            rows = [*zip(names, table, strict=True), ("strongest to weakest", table.max(axis=0) - table.min(axis=0))]
        for name, row in rows:
            print(f"| {name} | {' | '.join(f'{value:.1f}' if np.isfinite(value) else 'silent' for value in row)} |")


if __name__ == "__main__":
    main()
