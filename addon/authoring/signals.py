"""The probable signal of a source, by its name."""

from __future__ import annotations

import re

from ...core.frozen import frozen


@frozen
class SourceSignal:
    """A signal of a source's properties: its kind and, in hertz, its frequency."""

    signal: str
    frequency: float = 60.0
    amplitude: float = 1.0


# Typical strokes or revolutions per second of machines, within the tactile range.
_SIGNALS = (
    (SourceSignal("PULSE", 25.0), "jackhammer pneumatic breaker presslufthammer"),
    (SourceSignal("PULSE", 45.0), "drill hammerdrill bohrer chisel woodpecker"),
    (SourceSignal("PULSE", 1.2), "heart heartbeat pulse herz"),
    (SourceSignal("PULSE", 2.0), "footsteps drum hammer knock pile trommel"),
    (SourceSignal("PULSE", 12.0), "train locomotive rails tram zug"),
    (SourceSignal("SINE", 30.0), "engine motor car truck tractor boat ship generator diesel auto"),
    (
        SourceSignal("SINE", 50.0),
        "fridge transformer refrigerator compressor pump dishwasher washer washing fan "
        "ventilator machine maschine",
    ),
    (
        SourceSignal("SINE", 150.0),
        "phone telephone buzzer razor toothbrush bee insect saw grinder handy",
    ),
    (
        SourceSignal("SINE", 80.0),
        "speaker subwoofer loudspeaker guitar bass bell string lautsprecher",
    ),
    (
        SourceSignal("NOISE"),
        "wind rain river waterfall water steam jet rocket explosion earthquake gravel fire "
        "avalanche sand",
    ),
)
_WORDS = {word: signal for signal, words in _SIGNALS for word in words.split()}


def signal_for(name: str) -> SourceSignal:
    """The signal for an object of this name; a sine of 60 Hz for unknown names."""
    for word in reversed(
        re.findall(r"[^\W\d_]+", re.sub(r"(?<=[a-zäöüß])(?=[A-ZÄÖÜ])", " ", name))
    ):
        known = _WORDS.get(word.lower()) or _WORDS.get(word.lower().removesuffix("s"))
        if known is not None:
            return known
    return SourceSignal("SINE")
