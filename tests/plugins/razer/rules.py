"""What the schema of this format can't say, as the facts about it have it."""

from itertools import pairwise


def ascending(values):
    return all(a <= b for a, b in pairwise(values))


def check_haps(document, duration):
    melodies = document["m_vibration"]["m_melodies"]
    assert not document["m_texture"]["m_melodies"] and not document["m_stiffness"]["m_melodies"]
    for number, melody in enumerate(melodies):
        starts = [note["m_startingPoint"] for note in melody["m_notes"]]
        assert ascending(starts)
        for note in melody["m_notes"]:
            assert note["m_startingPoint"] + note["m_length"] <= duration + 0.05
            if number == 0:
                assert (
                    note["m_hapticEffect"] == {"m_type": 0}
                    and note["m_length"] == 0.022
                    and note["m_priority"] == 0
                )
                continue
            assert note["m_priority"] == 1
            for name in ("m_amplitudeModulation", "m_frequencyModulation"):
                keys = note["m_hapticEffect"][name]["m_keyframes"]
                assert ascending([key["m_time"] for key in keys])
                assert keys[0]["m_time"] == 0 and keys[-1]["m_time"] == note["m_length"]
            for key in note["m_hapticEffect"]["m_amplitudeModulation"]["m_keyframes"]:
                assert 0 <= key["m_value"] <= 1


def check_wyvrn(document, folder):
    (command,) = document["ExternalCommands"]
    for event in command["Haptic_Events"]:
        assert (folder / f"{event['Haptic_Effect']}.haps").is_file()
        assert len(event["Targeting"]) == 1


RULES = {
    ".haps": ("haps_v5", lambda document, path, tracks: check_haps(document, tracks.duration)),
    ".config": (
        "wyvrn_haptic_config",
        lambda document, path, tracks: check_wyvrn(document, path.parent),
    ),
}
"""Schema and check of a file, by its ending."""
