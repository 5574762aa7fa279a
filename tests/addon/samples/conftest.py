"""Samples played frame by frame with the add-on's own handler."""

from collections.abc import Callable, Iterator
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from haptic_tracing.addon.session import session


@pytest.fixture
def results() -> Callable[..., Iterator[Any]]:
    """The traced frames of a range, one after the other. The frame before it only starts the
    motion."""

    def of(scene: Any, first: int, last: int) -> Iterator[Any]:
        for frame in range(first, last + 1):
            scene.frame_set(frame)
            yield session.result_of(scene)

    return of


@pytest.fixture
def gain_along() -> Callable[..., float]:
    """The gain of a path by the closed form: the product over its objects of K e^(-max(K, eps) d),
    e^(-alpha d) where so chosen, the spreading of a front, or flesh that is felt all over; and a
    half where something else touches flesh."""

    def gain(scene: Any, result: Any, source: int, listener: int, path: tuple[str, ...]) -> float:
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
            if k == len(path) - 1 and result.listeners[listener].extent == "strongest":
                distance = max(0.0, distance - result.listeners[listener].radius)
            if haptics.function == "exponential":
                product *= np.exp(-haptics.alpha * distance)
            elif haptics.wave == "limb" and haptics.loss_factor == 0:
                product *= np.exp(-haptics.absorption * distance)
            elif haptics.function == "physical":  # a front: it only spreads
                product /= 1 + distance / haptics.reference_distance
            else:
                factor = (1 - haptics.kappa) * haptics.rho
                product *= factor * np.exp(-max(factor, scene.haptics.epsilon) * distance)
        flesh = [scene.objects[name].haptics.material.name == "Flesh" for name in path]
        return float(product * 0.5 ** (np.diff(flesh) != 0).sum())

    return gain
