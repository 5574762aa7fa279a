"""The visible part of an explosion: fire, smoke, a flash, a ring of dust. Nothing here is
haptic."""

from __future__ import annotations

import math
from random import Random

from bpy.types import Scene
from mathutils import Vector

from .animation import animate
from .geometry import Point, joined, rod, superellipsoid
from .lighting import add_point_light
from .materials import surface
from .staging import place

FIREBALLS, CLOUDS = 6, 5


def add_explosion(scene: Scene, centre: Vector, frame: int) -> None:
    """Fire that grows and goes within a second from ``frame`` on, smoke that follows it."""
    fire, core = (
        surface("Fire", "#ff5a08", 0.9, glow=2.0),
        surface("Fire Core", "#ffb02e", 0.9, glow=5.0),
    )
    smoke = surface("Smoke", "#6a625c", 1.0)
    draw = Random(9)
    for number in range(1, FIREBALLS + CLOUDS + 1):
        hot = number <= FIREBALLS
        out = Vector((draw.uniform(-1, 1), draw.uniform(-1, 1), draw.uniform(0.1, 1.0))) * (
            0.55 if hot else 0.8
        )
        size = draw.uniform(0.5, 0.9)
        name, material = (
            (f"Fireball {number}", core if number == 1 else fire)
            if hot
            else (f"Smoke {number - FIREBALLS}", smoke)
        )
        ball = place(
            scene, name, superellipsoid((size, size, size), 1.0, 16, 10), (material,), centre
        )
        start, grown, gone = (
            (frame, frame + 5, frame + 20) if hot else (frame + 5, frame + 16, frame + 50)
        )
        risen = centre + out * 1.5 + Vector((0.0, 0.0, 0.2 if hot else 1.6))
        animate(
            ball, "location", {start: tuple(centre), grown: tuple(centre + out), gone: tuple(risen)}
        )
        full = 1.0 if hot else 1.25
        animate(
            ball,
            "scale",
            {
                start - 1: (0, 0, 0),
                grown: (full,) * 3,
                gone - 8: (full * 0.9,) * 3,
                gone: (0, 0, 0),
            },
        )
    flash = add_point_light(
        scene, "Flash", tuple(centre + Vector((0.0, -0.3, 0.6))), 0.0, 0.4, "#ffb061"
    )
    animate(
        flash.data,
        "energy",
        {1.0: 0.0, frame - 1.0: 0.0, float(frame): 4000.0, frame + 8.0: 900.0, frame + 25.0: 0.0},
    )


def add_shock_ring(scene: Scene, centre: Point, frame: int, reach: float) -> None:
    """A ring of dust on the ground that runs out to ``reach`` metres within a quarter of a
    second."""
    ring = joined(rod(_on_circle(k), _on_circle(k + 1), 0.007, 8) for k in range(48))
    wave = place(
        scene, "Shock Wave", ring, (surface("Shock Wave", "#f2e6cf", 0.6, glow=0.4),), centre
    )
    animate(
        wave,
        "scale",
        {
            frame - 1: (0, 0, 0),
            frame: (0.2,) * 3,
            frame + 6: (reach, reach, 3.0),
            frame + 7: (0, 0, 0),
        },
    )


def _on_circle(k: int) -> Point:
    return (math.cos(2 * math.pi * k / 48), math.sin(2 * math.pi * k / 48), 0.0)
