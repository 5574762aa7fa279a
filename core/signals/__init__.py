"""Signals: small immutable values that compose by `*`, `+` and `>>` and are sampled only at the
end."""

from .automation import Automation, ramp
from .base import Delay, Gain, Loop, Product, Sequence, Signal, Sum
from .drawn import Drawing, Emphasis
from .envelopes import Adsr, Constant, Decay, Keyed
from .impacts import DecayingSine, Impulse
from .limits import MAX_FREQUENCY
from .noise import Noise
from .oscillators import Oscillator, Pulse, Saw, Sine, Square, Triangle
from .sampled import Sampled
from .serialization import SIGNAL_KINDS, signal_from_dict
from .struck import CORNER, LONGEST, Struck
from .templates import (
    DEFAULT_IMPACT,
    DEFAULT_PERSISTENT,
    IMPACT_MATERIALS,
    ImpactMaterial,
    impact_material,
    impact_template,
)
from .wav import read_wav
