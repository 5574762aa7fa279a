"""Oklab (Björn Ottosson, "A perceptual color space for image processing", 2020), and the line of
colours that the map goes along."""

from __future__ import annotations

import numpy as np
from haptic_tracing.addon.view.colour_map import hex_colour, linear

CONTROL_POINTS = ("#5a55b4", "#3b81b8", "#22a098", "#55bd6a", "#a8d53f", "#ffe93a")
_TO_CONE = np.array(
    [
        [0.4122214708, 0.5363325363, 0.0514459929],
        [0.2119034982, 0.6806995451, 0.1073969566],
        [0.0883024619, 0.2817188376, 0.6299787005],
    ]
)
_TO_LAB = np.array(
    [
        [0.2104542553, 0.7936177850, -0.0040720468],
        [1.9779984951, -2.4285922050, 0.4505937099],
        [0.0259040371, 0.7827717662, -0.8086757660],
    ]
)


def display(light: np.ndarray) -> np.ndarray:
    """Linear light as display values (sRGB, 0 to 1)."""
    light = np.clip(light, 0.0, 1.0)
    return np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)


def oklab(srgb: np.ndarray) -> np.ndarray:
    """Display values (..., 3) as Oklab (..., 3)."""
    return np.cbrt(linear(srgb) @ _TO_CONE.T) @ _TO_LAB.T


def from_oklab(lab: np.ndarray) -> np.ndarray:
    """Oklab (..., 3) as display values (..., 3), clipped to the gamut."""
    return display((lab @ np.linalg.inv(_TO_LAB).T) ** 3 @ np.linalg.inv(_TO_CONE).T)


def interpolated(steps: int) -> np.ndarray:
    """Display values (steps, 3): the control points joined in Oklab, at even distances along the
    line."""
    points = oklab(np.array([hex_colour(code) for code in CONTROL_POINTS]))
    fine = _along(points, np.linspace(0, 1, 8 * steps), np.linspace(0, 1, len(points)))
    way = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(fine, axis=0), axis=1))])
    return from_oklab(_along(fine, np.linspace(0, way[-1], steps), way))


def _along(points: np.ndarray, wanted: np.ndarray, at: np.ndarray) -> np.ndarray:
    return np.stack([np.interp(wanted, at, points[:, axis]) for axis in range(3)], axis=1)
