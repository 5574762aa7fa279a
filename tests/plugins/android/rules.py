"""What the schema of this format can't say, as Android's reference has it."""

from itertools import pairwise


def check_waveform(document, duration):
    timings, amplitudes = document["timings"], document["amplitudes"]
    assert len(timings) == len(amplitudes)
    assert all(timing > 0 for timing in timings)  # a sum of 0 is refused
    assert all(a != b for a, b in pairwise(amplitudes))
    assert 1000 * duration - 1 <= sum(timings) <= 1000 * duration + 100


RULES = {
    ".waveform": (
        "waveform",
        lambda document, path, tracks: check_waveform(document, tracks.duration),
    ),
}
"""Schema and check of a file, by its ending."""
