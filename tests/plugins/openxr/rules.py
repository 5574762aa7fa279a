"""What the schema of this format can't say, as the specification of the extension has it."""

from itertools import pairwise


def check_parametric(document, duration):
    vibrations = document["vibrations"]
    kinds = [vibration["streamFrameType"] for vibration in vibrations]
    assert kinds == ([0] if len(kinds) == 1 else [1, *[2] * (len(kinds) - 2), 3])
    lengths = []
    for vibration in vibrations:
        assert vibration["minFrequencyHz"] < vibration["maxFrequencyHz"]
        for points in (vibration["amplitudePoints"], vibration["frequencyPoints"]):
            assert points[0]["time"] == 0
            assert all(a["time"] < b["time"] for a, b in pairwise(points))
        length = vibration["amplitudePoints"][-1]["time"]
        assert vibration["frequencyPoints"][-1]["time"] == length
        times = [transient["time"] for transient in vibration["transients"]]
        assert times == sorted(times) and all(time < length for time in times)
        lengths.append(length)
    assert abs(sum(lengths) - 1e9 * duration) < 1e3 * len(lengths)


RULES = {
    ".parametric": (
        "parametric",
        lambda document, path, tracks: check_parametric(document, tracks.duration),
    ),
}
"""Schema and check of a file, by its ending."""
