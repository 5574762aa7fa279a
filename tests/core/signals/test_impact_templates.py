"""Impact templates: bounded, symmetric, different to the skin, and physically ordered."""

from __future__ import annotations

from itertools import combinations_with_replacement

import numpy as np
import pytest
from haptic_tracing.core.signals import (
    DEFAULT_IMPACT,
    DEFAULT_PERSISTENT,
    IMPACT_MATERIALS,
    DecayingSine,
    Sine,
    impact_template,
    signal_from_dict,
)

RATE = 8000.0
PAIRS = list(combinations_with_replacement(sorted(IMPACT_MATERIALS), 2))


def spectral_centroid(first: str, second: str) -> float:
    samples = impact_template(first, second).sample(0, 8000, RATE)
    spectrum = np.abs(np.fft.rfft(samples)) ** 2
    return float((spectrum * np.fft.rfftfreq(8000, 1 / RATE)).sum() / spectrum.sum())


def effective_duration(first: str, second: str) -> float:
    energy = np.cumsum(impact_template(first, second).sample(0, 16_000, RATE) ** 2)
    return float(np.searchsorted(energy, 0.9 * energy[-1]) / RATE)


def test_defaults() -> None:
    assert Sine(60.0) == DEFAULT_PERSISTENT
    assert isinstance(DEFAULT_IMPACT, DecayingSine)
    assert np.abs(DEFAULT_IMPACT.sample(0, 8000, RATE)).max() <= 1.0


@pytest.mark.parametrize(("first", "second"), PAIRS)
def test_every_pair(first: str, second: str) -> None:
    template = impact_template(first, second)
    samples = template.sample(0, 16_000, RATE)
    assert 0.9 < np.abs(samples).max() <= 1.0
    assert template.duration < 2.0
    assert template == impact_template(second, first)
    assert signal_from_dict(template.to_dict()) == template


def test_harder_is_higher_and_metal_rings_longest() -> None:
    assert (
        spectral_centroid("stone", "stone")
        > spectral_centroid("wood", "wood")
        > spectral_centroid("rubber", "rubber")
    )
    assert spectral_centroid("stone", "metal") > spectral_centroid("fabric", "metal")
    assert effective_duration("metal", "stone") > effective_duration("wood", "stone") > 0
    assert effective_duration("metal", "metal") == max(
        effective_duration(name, name) for name in IMPACT_MATERIALS
    )


def test_unknown_material_is_named() -> None:
    with pytest.raises(ValueError, match=r"^second: 'cheese' is not one of stone"):
        impact_template("stone", "cheese")


def test_every_material_that_can_be_hit_has_an_impact():
    """But springs: what is known of them is what they pass on, by the load that stands on them, and
    not how they sound when struck, so that they sound like a material that is not known."""
    from haptic_tracing.core.scene.materials import MATERIALS
    from haptic_tracing.core.scene.measured import SPRINGS
    from haptic_tracing.core.signals import impact_material

    silent = {name for name in MATERIALS if impact_material(name) is None}
    assert silent == {"air", *SPRINGS}
    assert impact_material("unobtainium") is None
