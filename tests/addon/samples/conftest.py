"""Samples played frame by frame with the add-on's own handler."""

from collections.abc import Callable, Iterator
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from haptic_tracing.addon.session import session
from haptic_tracing.core.scene.bands import BAND_CENTRES


@pytest.fixture
def results() -> Callable[..., Iterator[Any]]:
    """The traced frames of a range, one after the other. The frame before it only starts the
    motion."""

    def of(scene: Any, first: int, last: int) -> Iterator[Any]:
        for frame in range(first, last + 1):
            scene.frame_set(frame)
            yield session.result_of(scene)

    return of


def measured_gain(haptics: Any, distance: float, frequency: float) -> float:
    """The gain of a measured material by the definition of its function: spreading from r on until
    the wave fills the body's least sizes c and b, and damping of waves or of a limb."""
    r, c, b = haptics.reference_distance, haptics.plate_thickness, haptics.extent
    speed, waves = haptics.phase_speed, frequency
    spreading = 1.0
    if haptics.wave == "bounded":
        near, q = max(c - r, 0.0), max(r, c)
        filled = min(distance, near)
        over = min(distance, near + max(b - q, 0.0)) - filled
        spreading = 1 / (1 + filled / r) / np.sqrt(1 + over / q)
        speed = min(speed, 2 * np.sqrt(1.8 * speed * c * frequency))
    elif haptics.wave == "surface":
        spreading = 1 / np.sqrt(1 + distance / r)
    else:
        waves = max(frequency - haptics.resonance, 0.0)
    alpha = np.pi * waves * haptics.loss_factor / speed + haptics.absorption
    k = (1 - haptics.kappa) * haptics.rho
    own = np.log(k) / np.log(haptics.material_k)
    return float(min(1.0, k / haptics.material_k) * spreading * np.exp(-alpha * own * distance))


@pytest.fixture
def gain_along() -> Callable[..., float]:
    """The gain of a path, times the source's amplitude, by the closed form: the product over its
    objects of K e^(-max(K, eps) d), e^(-alpha d) where so chosen, or what measured materials pass
    on of a frequency [Hz]; contacts pass on everything, as what is light rides on what is heavy."""

    def gain(
        scene: Any,
        result: Any,
        source: int,
        listener: int,
        path: tuple[str, ...],
        frequency: float = BAND_CENTRES[0],
    ) -> float:
        number = {name: k for k, name in enumerate(result.objects)}
        places = [np.array(result.sources[source].position)]
        for a, b in pairwise(path):
            pair = sorted((number[a], number[b]))
            (row,) = np.flatnonzero((result.contacts.pairs == pair).all(axis=1))
            ends = result.contacts.positions[row]
            places += list(ends if pair[0] == number[a] else ends[::-1])
        places.append(np.array(result.listeners[listener].position))
        product = result.sources[source].amplitude
        for k, name in enumerate(path):
            haptics = scene.objects[name].haptics
            distance = float(np.linalg.norm(places[2 * k + 1] - places[2 * k]))
            if k == len(path) - 1:
                distance = max(0.0, distance - result.listeners[listener].radius)
            if haptics.function == "exponential":
                product *= np.exp(-haptics.alpha * distance)
            elif haptics.function == "physical":
                product *= measured_gain(haptics, distance, frequency)
            else:
                factor = (1 - haptics.kappa) * haptics.rho
                product *= factor * np.exp(-max(factor, 0.1) * distance)
        return float(product)

    return gain
