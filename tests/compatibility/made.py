"""Scenes that are made for comparison: every material struck, every kind of signal, and what the
collected files leave out."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

KEYS = {"times": [0.0, 0.2, 0.5], "values": [40.0, 120.0, 80.0]}
SWELL = {"times": [0.0, 0.25, 0.5], "values": [0.2, 1.0, 0.4]}
CLICK = {"signal": "decaying_sine", "frequency": 90.0, "decay": 0.05, "amplitude": 0.9}
SIGNALS: list[dict[str, Any]] = [
    {"signal": "sine", "frequency": KEYS, "amplitude": SWELL, "phase": 0.3},
    {"signal": "square", "frequency": 55.0, "amplitude": 0.7, "phase": 0.1},
    {"signal": "triangle", "frequency": 70.0, "amplitude": SWELL, "phase": 1.0},
    {"signal": "saw", "frequency": KEYS, "amplitude": 0.8, "phase": 0.0},
    {"signal": "pulse", "frequency": 25.0, "amplitude": 0.9, "phase": 0.2, "duty": 0.25},
    {"signal": "noise", "amplitude": 0.6, "seed": 7, "rate": 2000.0},
    {"signal": "constant", "value": 0.5, "duration": 0.3},
    {"signal": "adsr", "attack": 0.02, "decay": 0.1, "sustain": 0.5, "release": 0.2, "hold": 0.15},
    {"signal": "keyed", "track": SWELL},
    {"signal": "decay", "time_constant": 0.2},
    {"signal": "impulse", "width": 0.004, "amplitude": 0.8},
    CLICK,
    {"signal": "sampled", "samples": [0.0, 0.5, 1.0, 0.2, -0.7, -0.1], "rate": 400.0},
    {"signal": "gain", "of": {"signal": "sine", "frequency": 60.0}, "gain": SWELL},
    {"signal": "delay", "of": CLICK, "seconds": 0.12},
    {
        "signal": "product",
        "of": [{"signal": "sine", "frequency": 80.0}, {"signal": "decay", "time_constant": 0.1}],
    },
    {"signal": "sum", "of": [{"signal": "sine", "frequency": 80.0, "amplitude": 0.3}, CLICK]},
    {"signal": "sequence", "of": [{"signal": "constant", "value": 0.4, "duration": 0.1}, CLICK]},
    {
        "signal": "loop",
        "of": {"signal": "sampled", "samples": [0.0, 0.8, 0.1, -0.6], "rate": 100.0},
        "count": 5,
        "crossfade": 0.005,
    },
    {"signal": "struck", "of": CLICK, "pitch": 1.4, "decay": 0.6, "brightness": 0.5},
]


def write_scenes(folder: Path) -> None:
    """A scene with a signal of each kind, each on a block of its own, and one of listeners,
    triggers and tables."""
    _write(folder / "made every signal.json", _signals())
    _write(folder / "made listeners and triggers.json", _listeners())


def _write(path: Path, document: dict[str, Any]) -> None:
    path.write_text(json.dumps(document, indent=1), encoding="utf-8")


def _box(name: str, x: float, z: float, **more: Any) -> dict[str, Any]:
    shape = {"type": "box", "size": [0.8, 0.8, 0.5]}
    return {
        "name": name,
        "kappa": 0.2,
        "rho": 0.9,
        "shape": shape,
        "pose": {"position": [x, 0.0, z], "rotation": [1, 0, 0, 0]},
        **more,
    }


def _signals() -> dict[str, Any]:
    names = [f"{k:02} {form['signal']}" for k, form in enumerate(SIGNALS)]
    return {
        "format": "haptic-scene",
        "version": "1.1",
        "objects": [_box(name, 2.0 * k, 0.0) for k, name in enumerate(names)],
        "sources": [
            {
                "name": f"source {name}",
                "object": name,
                "position": [0.1, 0, 0.2],
                "amplitude": 0.9,
                "signal": form,
                "onset": 0.02,
            }
            for name, form in zip(names, SIGNALS, strict=True)
        ],
        "listeners": [
            {"name": f"hand {name}", "object": name, "position": [-0.2, 0.1, 0.2]} for name in names
        ],
    }


def _listeners() -> dict[str, Any]:
    listeners = [
        {
            "mixing": "cumulative",
            "ducking": 12.5,
            "radius": 0.1,
            "extent": "strongest",
            "limiter": True,
        },
        {"mixing": "weighted", "s_max": 0.3, "gain": 1.7, "extent": "mean_power", "radius": 0.2},
        {
            "mixing": "strongest",
            "ducking": 6.0,
            "body_part": "hand.R",
            "extent": "none",
            "radius": 0.3,
        },
        {"mixing": "power", "s_max": 0.5, "ducking": 20.0},
        {
            "mixing": "custom",
            "mixing_expression": "s_max * tanh((sum + 2 * strongest) / s_max)",
            "s_max": 0.8,
        },
    ]
    triggers = [
        {"on": "times", "times": [0.05, 0.2], "strengths": [1.0, 0.5], "by": ["cue", "other"]},
        {"on": "hit"},
        {
            "on": "passing",
            "object": "top",
            "pose": {"position": [0, 0, 1.0], "rotation": [1, 0, 0, 0]},
            "size": [1.0, 1.0, 0.1],
        },
    ]
    drawn = {
        "function": "expression",
        "expression": "exp(-0.4 * d) / (1 + d)",
        "band_gains": [1, 1, 0.9, 0.8, 0.6, 0.3],
    }
    return {
        "format": "haptic-scene",
        "version": "1.1",
        "settings": {
            "mode": "HT",
            "strategy": "all_paths",
            "max_connections": 12,
            "threshold": 0.0005,
            "epsilon": 0.05,
            "localise": 0.25,
        },
        "rules": {
            "templates": "by_material",
            "textures": [
                {
                    "between": [{"object": "top"}, {"material": "Sand"}],
                    "period": 0.002,
                    "sliding": 0.4,
                    "rolling": 0.2,
                    "noise": 0.5,
                    "bandwidth": 0.7,
                    "stick_speed": 0.01,
                    "full_force": 20.0,
                    "full_speed": 1.5,
                }
            ],
        },
        "materials": [
            {"name": "Sand", "kappa": 0.6, "rho": 0.5, "use_delay": True, "wave_speed": 150.0}
        ],
        "objects": [
            _box("base", 0.0, 0.0, motion="static", material="Sand", impact_material="sand"),
            _box("middle", 0.1, 0.5, mass=3.0, impact_material="glass", propagation=drawn),
            _box(
                "top",
                0.2,
                1.0,
                motion="dynamic",
                mass=1.5,
                propagation={"function": "physical", "wave": "plate", "loss_factor": 0.02},
            ),
        ],
        "sources": [
            {
                "name": "drill",
                "object": "base",
                "position": [0.2, 0.1, 0],
                "priority": 3.0,
                "amplitude": 0.4,
            },
            {
                "name": "hum",
                "object": "middle",
                "position": [0, 0, 0],
                "priority": 1.0,
                "signal": {"signal": "sine", "frequency": 90.0, "amplitude": 0.6},
            },
            {
                "name": "cue",
                "object": "top",
                "position": [0, 0, 0.1],
                "signal": CLICK,
                "triggers": triggers,
                "priority": 5.0,
            },
        ],
        "listeners": [
            {
                "name": f"listener {k}",
                "object": ("middle", "top")[k % 2],
                "position": [0.1 * k - 0.2, 0.1, 0.1],
                **form,
            }
            for k, form in enumerate(listeners)
        ],
        "frame_rate": 24.0,
        "frame_start": 1,
        "frames": [
            {"frame": 1},
            {"frame": 3, "amplitudes": {"hum": 0.5}, "gains": {"listener 0": 0.7}},
            {"frame": 6, "poses": {"top": [0.25, 0, 1.0, 1, 0, 0, 0]}, "removed_listeners": []},
        ],
    }


def build_materials(scene: Any) -> None:
    """Fill an empty scene: two balls of each material of the library fall onto plates of wood and
    of their own material; a listener on each plate, with the measured functions on every third
    one."""
    import bpy
    from haptic_tracing.addon.authoring import materials as library
    from haptic_tracing.core.scene.materials import MATERIALS

    world = [
        (name, material, plate)
        for name, material in MATERIALS.items()
        for plate in (material, MATERIALS["hardwood"])
    ]
    for k, (name, material, under) in enumerate(world):
        x, y = 2.0 * (k % 10), 2.0 * (k // 10)
        bpy.ops.mesh.primitive_cube_add(size=1, location=(x, y, -0.1), scale=(1.2, 1.2, 0.2))
        plate = bpy.context.object
        bpy.ops.mesh.primitive_cube_add(size=0.3, location=(x + 0.1, y, 0.6))
        block = bpy.context.object
        for obj, made_of, kind in ((plate, under, "PASSIVE"), (block, material, "ACTIVE")):
            bpy.ops.object.select_all(action="DESELECT")
            bpy.context.view_layer.objects.active = obj
            bpy.ops.rigidbody.object_add(type=kind)
            obj.haptics.enabled = True
            library.apply([obj], library.preset_in(scene, made_of))
        plate.name, block.name = f"{name} {k} plate", f"{name} {k}"
        block.rigid_body.kinematic, block.rigid_body.mass = True, 2.0
        for frame, z in ((1, 0.6), (5, 0.15), (12, 0.15)):
            block.location.z = z
            block.keyframe_insert("location", frame=frame)
        if k % 3 == 0:
            library.make_physical([plate], in_a_building=k % 2 == 0)
        plate.haptics.listener.enabled = True
    scene.frame_start, scene.frame_end = 1, 12
