"""What files say of their origin, and the paragraph for a paper."""

import hashlib
import json
from dataclasses import replace

import haptic_tracing
import numpy as np
import pytest
from haptic_tracing.core.formats import haptic_scene, registry
from haptic_tracing.core.formats.export import Export
from haptic_tracing.core.formats.io import catalogue
from haptic_tracing.core.formats.tracks.listener_tracks import ListenerTrack, Tracks
from haptic_tracing.core.scene.values import HapticObject, HapticScene, Settings

WITHOUT = {"wyvrn"}
"""Formats without a place for a remark, as docs/formats.md says."""
TIME = np.arange(4000) / 8000
TRACKS = Tracks(
    (ListenerTrack("hand", "hand.L", np.array([[0.1, 0.5]])),),
    8000,
    0.4 * np.sin(2 * np.pi * 80 * TIME)[None],
)
SCENE = HapticScene(
    objects=(HapticObject("ground", 0.2, 0.9),),
    settings=Settings(mode="SD", strategy="as_in_the_paper", threshold=0.0125),
)


def digest_of(document):
    """The first digits of the SHA-256 of a scene file's static part, without its extras."""
    kept = ("format", "version", "convention", "settings", "rules", "objects", "contacts")
    document = {key: document[key] for key in (*kept, "sources", "listeners") if key in document}
    numbers = json.loads(json.dumps(document), parse_int=float)  # 1 and 1.0 are the same
    text = json.dumps(numbers, ensure_ascii=False, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()[:12]


@pytest.mark.parametrize("name", catalogue.formats())
def test_every_format_says_where_it_comes_from(tmp_path, name):
    export = Export("ride", SCENE, TRACKS)
    options = {"tracks": "wav"} if name == "scene" else {}
    files = registry.write(name, export, tmp_path, options).files
    digest = digest_of(haptic_scene.scene_to_dict(SCENE))
    texts = [path.read_bytes().decode("latin-1") for path in files]
    wanted = ("Haptic Tracing", haptic_tracing.__version__, "as_in_the_paper", "epsilon", digest)
    for text in texts:
        assert [word in text for word in wanted] == [name not in WITHOUT] * len(wanted)


def test_the_wave_has_its_comment_where_riff_has_it(tmp_path):
    registry.write("wav", Export("ride", SCENE, TRACKS), tmp_path)
    data = (tmp_path / "ride.wav").read_bytes()
    chunks, place = {}, 12
    while place < len(data):
        size = int.from_bytes(data[place + 4 : place + 8], "little")
        chunks[data[place : place + 4]] = data[place + 8 : place + 8 + size]
        place += 8 + size + size % 2
    assert place == len(data) and list(chunks) == [b"fmt ", b"LIST", b"data"]
    info = chunks[b"LIST"]
    assert info[:8] == b"INFOICMT" and int.from_bytes(info[8:12], "little") == len(info) - 12
    assert info[12:].startswith(b"Haptic Tracing ") and info.endswith(b"\0")


def test_a_scene_keeps_its_digest_until_something_changes_that_is_felt(tmp_path):
    first, second = tmp_path / "a.json", tmp_path / "b.json"
    scene = replace(SCENE, extras={"studio": "north", "provenance": {"program": "another"}})
    haptic_scene.write_export(Export("ride", scene), first)
    document = json.loads(first.read_text("utf-8"))
    said = document["extras"]["provenance"]
    assert document["extras"]["studio"] == "north" and said["program"] == "Haptic Tracing"
    assert said["scene"] == digest_of(document)
    haptic_scene.write_export(haptic_scene.read_export(first), second)
    assert second.read_bytes() == first.read_bytes()
    louder = replace(SCENE, objects=(replace(SCENE.objects[0], kappa=0.3),))
    assert Export("ride", louder).provenance["scene"] != said["scene"]


def test_tracks_without_a_scene_say_what_they_came_with():
    assert Export("ride", tracks=TRACKS).provenance == {
        "program": "Haptic Tracing",
        "version": haptic_tracing.__version__,
    }
    origin = Export("ride", SCENE).provenance
    assert Export("ride", tracks=TRACKS, origin=origin).provenance == origin


def test_the_paragraph_names_what_a_reader_needs_to_repeat_it():
    scene = replace(SCENE, settings=replace(SCENE.settings, mode="HT", max_connections=None))
    export = Export("ride", scene, TRACKS)
    text = export.methods()
    for words in (
        f"Haptic Tracing {haptic_tracing.__version__} from a scene of 1 object, 0 sources",
        export.provenance["scene"],
        "The mode was HT (Haptic Tracing: through touching objects",
        "strategy As in the Paper",
        "ε = 0.1 1/m, paths ended below a gain of 0.0125)",
        "Objects within 10 mm touched. Collisions of 0.05 J or more were impacts",
        "Each listener's signal has 0.5 s at 8,000 Hz.",
    ):
        assert words in text
    assert "connections" not in text and "Objects within" not in Export("ride", SCENE).methods()
    with pytest.raises(ValueError, match="carries the scene"):
        Export("ride", tracks=TRACKS).methods()
