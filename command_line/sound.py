"""``haptic-tracing sound IN.wav``: a sound as the signal of a source, as the add-on converts it."""

from __future__ import annotations

import argparse

from ..core.devices.profile_files import profile
from ..core.formats.io.atomic import write_text
from ..core.formats.io.json_text import compact
from ..core.signals.felt_sound import Feel, felt_onsets, vibration
from ..core.signals.sound import Clip, heard, mixed, outcome
from ..core.signals.wav import WavFile
from . import answer
from .standard_streams import DASH


def run(args: argparse.Namespace) -> int:
    """Convert, write, print how many onsets there are. Exit code 0."""
    follows = args.carrier == "pitch"
    try:
        fixed = Feel().frequency if follows else float(args.carrier)
    except ValueError:
        fixed = profile(args.carrier).best_frequency
    feel = Feel(frequency=fixed, pitch=follows, gate=args.gate, gain=args.gain)
    try:
        with args.sound.open("rb") as file:
            found = outcome(heard(outcome(mixed((Clip(WavFile(file)),)))))
        signal = vibration(found, feel)
    except ValueError as error:
        raise ValueError(f"{args.sound}: {error}") from None
    onsets = felt_onsets(found, feel)[0]
    if args.output == DASH:
        print(compact(signal.to_dict()), file=args.stdout)
        return 0
    write_text(args.output, (compact(signal.to_dict()),))
    print(f"{args.output}: {found.seconds:.2f} s, {len(onsets)} onsets")
    result = {"files": [str(args.output)], "seconds": found.seconds, "onsets": len(onsets)}
    answer(args, result)
    return 0
