"""Ready signals: the defaults and the impact of one material on another."""
from __future__ import annotations

from .impacts import DecayingSine
from .oscillators import Sine
from .signal import Signal

DEFAULT_PERSISTENT: Signal = Sine(60.0)
DEFAULT_IMPACT: Signal = DecayingSine(150.0, 0.03)
