"""Vibrations of imported files and converted sounds, which a .blend keeps as JSON.

The text may come from an untrusted file: `signal_of_text` validates it by the schema of signals.
"""

from __future__ import annotations

import json
from functools import lru_cache

from ...core.formats.io.scene_schema import SCENE
from ...core.formats.io.schema import validate
from ...core.formats.io.strict_json import parse_json
from ...core.signals import Signal, signal_from_dict


def text_of_signal(signal: Signal) -> str:
    """The text for `signal_of_text`."""
    return json.dumps(signal.to_dict(), ensure_ascii=False, allow_nan=False, separators=(",", ":"))


@lru_cache(maxsize=256)
def signal_of_text(text: str) -> Signal | None:
    """The kept signal, None for no text. Raises ValueError if the text is damaged."""
    if not text:
        return None
    try:
        form = parse_json(text.encode("utf-8", "surrogatepass"), "its signal")
        validate(form, f"{SCENE}#signal", "its signal")
        return signal_from_dict(form)
    except ValueError as error:
        raise ValueError(f"its kept signal is damaged: import the file again ({error})") from None
