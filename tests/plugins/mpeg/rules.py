"""What the schema of this format can't say, as the facts about it have it."""

from itertools import pairwise


def ascending(values):
    return all(a <= b for a, b in pairwise(values))


def check_hjif(document, listeners, duration):
    assert document["timescale"] == 1000
    assert {avatar["id"] for avatar in document["avatars"]} >= {
        perception["avatar_id"] for perception in document["perceptions"]
    }
    (perception,) = document["perceptions"]
    assert "effect_semantic_scheme" not in perception  # the reference software refuses it
    devices = [device["id"] for device in perception["reference_devices"]]
    assert len(set(devices)) == len(devices)
    for device in perception["reference_devices"]:
        assert device["minimum_frequency"] <= device["maximum_frequency"]
    channels = perception["channels"]
    assert [channel["id"] for channel in channels] == list(range(listeners))
    assert document["level"] == (1 if listeners <= 127 else 2)
    for channel in channels:
        assert channel.get("reference_device_id", devices[:1] and devices[0]) in [
            *devices,
            *([] if devices else [[]]),
        ]
        assert len(channel["bands"]) <= 7
        for band in channel["bands"]:
            assert band["band_type"] in ("VectorialWave", "Transient") and "curve_type" not in band
            assert band["lower_frequency_limit"] < band["upper_frequency_limit"]
            assert ascending([effect["position"] for effect in band["effects"]])
            for effect in band["effects"]:
                positions = [keyframe["relative_position"] for keyframe in effect["keyframes"]]
                assert (
                    ascending(positions)
                    and len(set(positions)) == len(positions)
                    and positions[-1] <= 65535
                )
                assert (
                    effect["effect_type"] == "Basis"
                    and effect["position"] + positions[-1] <= 1000 * duration + 50
                )
                if band["band_type"] == "VectorialWave":
                    first, last = effect["keyframes"][0], effect["keyframes"][-1]
                    # Players disagree on what holds before the first key and after the last: there
                    # is one at either end.
                    assert {
                        "amplitude_modulation",
                        "frequency_modulation",
                    } <= first.keys() & last.keys()
                    for keyframe in effect["keyframes"]:
                        frequency = keyframe.get(
                            "frequency_modulation", first["frequency_modulation"]
                        )
                        assert (
                            band["lower_frequency_limit"]
                            <= frequency
                            <= band["upper_frequency_limit"]
                            and frequency > 0
                        )


RULES = {
    ".hjif": (
        "hjif",
        lambda document, path, tracks: check_hjif(document, len(tracks.listeners), tracks.duration),
    ),
}
"""Schema and check of a file, by its ending."""
