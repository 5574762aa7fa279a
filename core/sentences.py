"""Messages as sentences, and the formatting of their arguments."""

from __future__ import annotations

from .message import Argument, Chain, Decibels, Hertz, Message, Metres, Names, Seconds

_LONGEST_CHAIN = 6


def sentence(message: Message, template: str | None = None) -> str:
    """A message as a sentence without a full stop: in English, or by the ``template`` of another language."""
    return (template or message.cause.value).format_map({name: written(value) for name, value in message.arguments})


def written(value: Argument) -> str:
    """An argument as text: numbers with their unit, long paths shortened in the middle."""
    match value:
        case Metres():
            return _length(value)
        case Decibels():
            return decibels(value)
        case Hertz():
            return f"{value:.0f} Hz"
        case Seconds():
            return f"{1000 * value:.0f} ms" if abs(value) < 0.1 else f"{value:.2f} s"
        case Chain():
            return " > ".join(value if len(value) <= _LONGEST_CHAIN else (*value[:3], "...", *value[-2:]))
        case Names():
            return ", ".join(value)
    return str(value)


def decibels(value: float) -> str:
    """Whole decibels with a real minus sign: "−12 dB"."""
    return f"\N{MINUS SIGN}{-value:.0f} dB" if round(value) < 0 else f"{abs(value):.0f} dB"


def _length(metres: float) -> str:
    if metres < 0.01:
        return f"{1000 * metres:.1f} mm"
    return f"{100 * metres:.1f} cm" if metres < 1 else f"{metres:.1f} m"
