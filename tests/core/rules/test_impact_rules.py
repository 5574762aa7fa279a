"""What a rule makes of an impact: curves over its strength, and variations that depend on the
impact alone."""

import math

import numpy as np
import pytest
from haptic_tracing.core.scene.impact_rule import ImpactRule
from haptic_tracing.core.signals import Constant, DecayingSine, Gain, Sampled, Sine, Struck

RING = DecayingSine(200.0, 0.05)
PAIR = ("anvil", "hammer")
STEP = 2 ** (1 / 96) - 1  # pitches are a 48th of an octave apart
VARIED = ImpactRule(variation=0.2, seed=7)


def test_by_default_amplitude_is_the_part_of_the_full_energy():
    for energy in (0.0, 0.3, 1.0):
        assert ImpactRule().played(RING, energy, PAIR, 1.0) == (RING, energy)


@pytest.mark.parametrize("energy", [0.05, 0.4, 1.0])
def test_curves_go_from_weak_to_full_with_the_strength(energy):
    rule = ImpactRule(gain=(0.1, 0.9), pitch=(0.5, 2.0), decay=(0.2, 1.0), brightness=(0.0, 0.6))
    signal, amplitude = rule.played(RING, energy, PAIR, 1.0)
    assert amplitude == pytest.approx(0.1 + 0.8 * energy)
    assert (signal.decay, signal.brightness) == pytest.approx((0.2 + 0.8 * energy, 0.6 * energy))
    assert signal.pitch == pytest.approx(0.5 + 1.5 * energy, rel=STEP)
    assert signal.of is RING


def test_the_same_impact_sounds_the_same_and_others_differ():
    first = VARIED.played(RING, 0.5, PAIR, 1.25)
    assert VARIED.played(RING, 0.5, PAIR[::-1], 1.25) == first
    others = [
        VARIED.played(RING, 0.5, PAIR, 1.26),
        VARIED.played(RING, 0.5, ("anvil", "nail"), 1.25),
        ImpactRule(variation=0.2, seed=8).played(RING, 0.5, PAIR, 1.25),
    ]
    assert len({first, *others}) == 4


def test_variations_are_even_and_stay_in_their_range():
    """Uniform, as far as the moments of 2,000 of them tell: mean and variance of uniform numbers,
    within five standard errors."""
    played = [VARIED.played(RING, 0.5, PAIR, 0.01 * number) for number in range(2000)]
    parts = np.array(
        [
            [(signal.pitch - 0.8) / 0.4, (1 - signal.decay) / 0.2, (1 - amplitude / 0.5) / 0.2]
            for signal, amplitude in played
        ]
    )
    assert parts.min() >= -STEP / 0.4 * 1.2 and parts.max() <= 1 + STEP / 0.4 * 1.2
    assert parts.mean(axis=0) == pytest.approx([0.5] * 3, abs=5 * math.sqrt(1 / 12 / 2000))
    assert parts.var(axis=0) == pytest.approx([1 / 12] * 3, abs=5 * math.sqrt(1 / 180 / 2000))
    assert np.abs(np.corrcoef(parts.T) - np.eye(3)).max() < 5 / math.sqrt(2000)


def test_pitch_and_decay_keep_what_a_template_allows():
    for number in range(50):
        signal, amplitude = ImpactRule(variation=1.0, pitch=(0.25, 4.0), decay=(0.01, 0.01)).played(
            RING, number % 2, PAIR, number
        )
        assert isinstance(signal, Struck) and 0 <= amplitude <= 1


@pytest.mark.parametrize(
    ("arguments", "words"),
    [({"template": Sine(60.0)}, "template: .* end within 60"), ({"template": DecayingSine(60.0, 7.0)}, "template: .* end within 60"),
     ({"template": Gain(RING, 0.0)}, "template: .* silent"), ({"template": Sampled([0.0, 0.0])}, "template: .* silent"),
     ({"template": Constant(1e-5, 1.0)}, "template: .* silent"), ({"template": "loud"}, "loud"), ({"gain": (0.0, 1.5)}, "gain"),
     ({"pitch": (0.0, 1.0)}, "pitch"), ({"decay": (math.nan, 1.0)}, "decay"),
     ({"brightness": (-1.0, 1.0)}, "brightness"),
     ({"variation": 2.0}, "variation")],
)  # fmt: skip
def test_faults_are_named(arguments, words):
    with pytest.raises(ValueError, match=words):
        ImpactRule(**arguments)
