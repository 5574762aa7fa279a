"""The ten listeners of three samples with the paper's function, with measured materials, and with these and contacts by impedance.

``python -m haptic_tracing.study.physical_scenes`` prints the tables of `docs/functions.md`.
"""

from __future__ import annotations

from dataclasses import replace
from importlib import import_module

import bpy
import haptic_tracing
import numpy as np
from bpy.types import Scene

from ..addon.properties.function import PARAMETERS
from ..addon.session import session
from ..core.render.history import still_samples
from ..core.scene.materials import MATERIALS
from ..core.scene.measured import physical
from ..core.scene.skeleton import part_in
from ..sample_scenes import materials as substances

SAMPLES = (("jackhammer_bench", 3), ("hammer_nail", 20), ("mine_ride", 2600))
"""Module and frame: the jackhammer at work, the blow on the nail, the cart that rumbles."""
WAYS = ("paper", "physical", "physical, impedance")

_NAMES = {
    "STEEL": "steel",
    "STONE": "stone",
    "CONCRETE": "concrete",
    "WOOD": "softwood",
    "SOIL": "soil",
    "RUBBER": "rubber",
    "CLOTH": "fabric",
    "FLESH": "flesh",
}
_PRESETS = {replace(getattr(substances, constant)): MATERIALS[name] for constant, name in _NAMES.items()}


def levels(module: str, frame: int) -> tuple[list[str], np.ndarray]:
    """Names of the listeners (l,), and their levels [dB of full scale] (l, ways) during a second of the sources as they are in a frame."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.context.scene
    import_module(f"haptic_tracing.sample_scenes.{module}").build(scene)
    scene.haptics.strategy = "auto"
    columns: list[np.ndarray] = []
    names: list[str] = []
    for way in WAYS:
        if way == WAYS[1]:
            _make_physical(scene)
        elif way == WAYS[2]:
            rule = scene.haptics.transmission_table.items.add()
            rule.first_kind = rule.second_kind = "ANY"
            rule.function = "impedance"
        for number in range(frame - 2, frame + 1):
            scene.frame_set(number)
            bpy.context.view_layer.update()
            result = session.result_of(scene)
        assert result is not None
        names = [item.name for item in result.listeners]
        with np.errstate(divide="ignore"):
            columns.append(10 * np.log10((still_samples(result, 1.0) ** 2).mean(axis=1)))
    return names, np.stack(columns, axis=1)


def _make_physical(scene: Scene) -> None:
    """Give every object of a substance of the samples the measured function of that material."""
    for obj in scene.objects:
        haptics = obj.haptics
        own_values = (round(haptics.kappa, 3), round(haptics.rho, 3))
        material = next((preset for item, preset in _PRESETS.items() if (item.kappa, item.rho) == own_values), None)
        if haptics.enabled and material is not None and not haptics.medium:
            haptics.kappa, haptics.rho = material.kappa, material.rho
            form = physical(material.name, tuple(obj.dimensions), part=part_in(obj.name)).to_dict()
            haptics.function = form.pop("function")
            for key, own in PARAMETERS["physical"].items():
                setattr(haptics, own, form[key])


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
