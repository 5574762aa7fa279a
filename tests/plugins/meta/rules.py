"""What the schema of this format can't say, as the facts about it have it."""

from itertools import pairwise


def ascending(values):
    return all(a <= b for a, b in pairwise(values))


def check_haptic(document, duration):
    envelopes = document["signals"]["continuous"]["envelopes"]
    amplitude, frequency = envelopes["amplitude"], envelopes["frequency"]
    times = [point["time"] for point in amplitude]
    assert len(times) >= 2 and ascending(times) and 0 < times[-1] <= duration + 1e-3
    assert ascending([point["time"] for point in frequency])
    assert not frequency or frequency[-1]["time"] <= times[-1]
    for point in amplitude:
        assert point.get("emphasis", {"amplitude": 1})["amplitude"] >= point["amplitude"]
    assert {"editor", "source", "description"} <= document["metadata"].keys()


RULES = {
    ".haptic": (
        "haptic_v1",
        lambda document, path, tracks: check_haptic(document, tracks.duration),
    ),
}
"""Schema and check of a file, by its ending."""
