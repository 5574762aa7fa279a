"""What the schema of this format can't say, as the facts about it have it."""

from itertools import pairwise


def ascending(values):
    return all(a <= b for a, b in pairwise(values))


def check_ahap(document, duration):
    sounding = []
    for entry in document["Pattern"]:
        if "Event" in entry:
            event = entry["Event"]
            assert 0 <= event["Time"] <= duration and event.get("EventDuration", 0) <= 30
            for parameter in event["EventParameters"]:
                assert 0 <= parameter["ParameterValue"] <= 1
            if event["EventType"] == "HapticContinuous":
                sounding.append((event["Time"], event["Time"] + event["EventDuration"]))
        else:
            points = entry["ParameterCurve"]["ParameterCurveControlPoints"]
            assert 1 <= len(points) <= 16
            assert points[0]["Time"] == 0 and ascending(
                [point["Time"] for point in points]
            )  # relative to the curve
            assert all(0 <= point["ParameterValue"] <= 1 for point in points)
            assert entry["ParameterCurve"]["Time"] + points[-1]["Time"] <= duration + 0.1
    assert all(end <= start + 1e-6 for (_, end), (start, _) in pairwise(sounding))


RULES = {
    ".ahap": ("ahap", lambda document, path, tracks: check_ahap(document, tracks.duration)),
}
"""Schema and check of a file, by its ending."""
