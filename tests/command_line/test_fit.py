"""``haptic-tracing fit``: values that synthetic recordings were made with come back, and what they
do not determine is said."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from haptic_tracing.command_line import main
from haptic_tracing.core.formats.scene.scene_json import read_scene, write_scene
from haptic_tracing.core.formats.tracks.listener_tracks import ListenerTrack, Tracks
from haptic_tracing.core.formats.tracks.wav import write_wav
from haptic_tracing.core.scene.coefficients import coefficients_of
from haptic_tracing.core.scene.functions import Constant, Physical, Wave
from haptic_tracing.core.scene.values import Contact, HapticObject, HapticScene, Listener, Source

RATE, SECONDS = 4000, 20
DAMPING, GAIN = 1.7, 0.4
"""What the recordings are made with: the material's damping times so much, and the contact's
gain."""
LENGTH, LOSS, SPEED = 3.0, 0.06, 200.0


def scene(length: float = LENGTH) -> HapticScene:
    """A floor of which a pad carries a listener; the scene does not know the floor's damping and
    the contact's gain."""
    soil = Physical(
        wave=Wave.SURFACE,
        loss_factor=LOSS,
        phase_speed=SPEED,
        material_k=0.28,
        reference_distance=0.5,
    )
    at = (length, 0.0, 0.0)
    return HapticScene(
        (
            HapticObject("floor", 0.6, 0.7, soil),
            HapticObject("pad", 0.5, 0.5, Constant(gain_value=0.8)),
        ),
        (Contact(("floor", "pad"), (at, at)),),
        (Source("motor", "floor"),),
        (Listener("hand", "pad", at),),
    )


def recordings(folder, noise: float = 0.0, length: float = LENGTH) -> list[str]:
    """Noise at the source, and what a filter with the formula of a damped surface wave makes of it,
    with so much noise beside it."""
    generator = np.random.default_rng(8)
    source = 0.1 * generator.normal(size=RATE * SECONDS)
    frequency = np.fft.rfftfreq(len(source), 1 / RATE)
    spread = (1 + length / 0.5) ** -0.5
    alpha = math.pi * frequency * LOSS / SPEED * DAMPING
    heard = np.fft.irfft(
        np.fft.rfft(source) * spread * np.exp(-alpha * length) * GAIN * 0.8, len(source)
    )
    heard += noise * heard.std() * generator.normal(size=len(heard))
    paths = []
    for name, samples in (("source", source), ("listener", heard)):
        path = folder / f"{name}.wav"
        write_wav(Tracks((ListenerTrack(name, ""),), RATE, samples[None]), path, "float32")
        paths.append(str(path))
    return paths


def fitted(folder, capsys, *more, length: float = LENGTH, **options) -> dict:
    path = folder / "scene.json"
    write_scene(scene(length), path)
    arguments = ["--source", "motor", "--listener", "hand", "--object", "floor", *more]
    assert main(["fit", str(path), *recordings(folder, length=length, **options), *arguments]) == 0
    return json.loads(capsys.readouterr().out)


@pytest.mark.parametrize(
    ("noise", "within"), [(0.0, 0.05), (0.1, 0.2)]
)  # none, and 20 dB below what is heard
def test_known_values_come_back(tmp_path, capsys, noise, within):
    found = fitted(
        tmp_path,
        capsys,
        "--contact",
        "floor",
        "pad",
        noise=noise,
    )
    assert found["object"]["damping"] == pytest.approx(DAMPING, rel=within)
    assert found["contact"]["gain"] == pytest.approx(GAIN, rel=within)
    assert found["not_determined"] == []
    assert found["difference_after"] < 0.1 * found["difference_before"] + 1


def test_the_written_scene_has_the_fitted_values(tmp_path, capsys):
    out = tmp_path / "new.json"
    found = fitted(tmp_path, capsys, "--contact", "floor", "pad", "--out", str(out))
    written = read_scene(out)
    assert (written.objects[0].kappa, written.objects[0].rho) == pytest.approx(
        coefficients_of(0.28 ** found["object"]["damping"], 0.7)
    )
    assert written.contacts[0].transmission.gain_value == pytest.approx(found["contact"]["gain"])


def test_a_loss_below_three_decibels_is_not_determined(tmp_path, capsys):
    found = fitted(tmp_path, capsys, "--contact", "floor", "pad", length=0.1)
    assert "a loss below 3 dB is not determined" in found["not_determined"][0]


def test_recordings_with_nothing_in_common_are_refused(tmp_path, capsys):
    path = tmp_path / "scene.json"
    write_scene(scene(), path)
    source, listener = recordings(tmp_path, noise=1e4)
    assert (
        main(
            [
                "fit",
                str(path),
                source,
                listener,
                "--source",
                "motor",
                "--listener",
                "hand",
                "--object",
                "floor",
            ]
        )
        == 2
    )
    assert "nothing in common" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("argument", "words"), [("--source", "no such source"), ("--listener", "no such listener")]
)
def test_wrong_names_are_one_line(tmp_path, capsys, argument, words):
    path = tmp_path / "scene.json"
    write_scene(scene(), path)
    names = {"--source": "motor", "--listener": "hand", "--object": "floor", argument: "nobody"}
    assert (
        main(
            [
                "fit",
                str(path),
                *recordings(tmp_path),
                *[part for pair in names.items() for part in pair],
            ]
        )
        == 2
    )
    assert words in capsys.readouterr().err


def test_an_object_without_a_loss_by_frequency_is_refused(tmp_path, capsys):
    path = tmp_path / "scene.json"
    write_scene(scene(), path)
    assert (
        main(
            [
                "fit",
                str(path),
                *recordings(tmp_path),
                "--source",
                "motor",
                "--listener",
                "hand",
                "--object",
                "pad",
            ]
        )
        == 2
    )
    assert "only objects with the function physical" in capsys.readouterr().err
