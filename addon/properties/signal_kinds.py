"""The signals of sources that a kind and a frequency describe completely.

A new one is an entry here, and its picture ``thumbnails/signal-KIND.png``: the choices of signals,
the reader, the importer and the panel use this table.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

from ...core import signals
from ..blender.single_precision import shortest

if TYPE_CHECKING:
    from ...core.signals import Automation, Signal

HERTZ = (0.1, 1000.0)
"""Range of the frequencies of sources [Hz]."""


class PlainSignal(NamedTuple):
    """A kind of signal.

    Args:
        number: By which files store the kind; a new one gets the next that is free in
            `source.SIGNAL_ITEMS`.
        label: Its name in the panel.
        about: Its tooltip.
        make: The signal of a frequency [Hz].
        is_tuned: Whether it has a frequency.
    """

    number: int
    label: str
    about: str
    make: Callable[[float | Automation], Signal]
    is_tuned: bool = True


PLAIN = {
    "SINE": PlainSignal(0, "Sine", "A pure vibration", lambda hertz: signals.Sine(hertz)),
    "PULSE": PlainSignal(
        1,
        "Pulse Train",
        "Regular blows, like those of a jackhammer",
        lambda hertz: signals.Pulse(hertz),
    ),
    "NOISE": PlainSignal(
        2, "Noise", "A rough, random vibration", lambda hertz: signals.Noise(), is_tuned=False
    ),
}


def kind_of(signal: Signal | None) -> tuple[str, float] | None:
    """The kind of a signal and its frequency [Hz]; None if the properties of a source cannot hold
    it, such as a sine with an amplitude of its own."""
    frequency = getattr(signal, "frequency", 60.0)
    if not isinstance(frequency, float) or not HERTZ[0] <= frequency <= HERTZ[1]:
        return None
    if shortest(frequency) != frequency:
        return None
    fitting = (kind for kind, plain in PLAIN.items() if plain.make(frequency) == signal)
    return next(((kind, frequency) for kind in fitting), None)
