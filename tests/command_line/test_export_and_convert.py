"""``export`` and ``convert`` as they are typed: files, what is printed, and one line with exit code
2 for what is wrong."""

import json
import os
import subprocess
import sys
import wave
from dataclasses import replace

import numpy as np
import pytest
from haptic_tracing.command_line import main
from haptic_tracing.core.formats import registry
from haptic_tracing.core.formats.export import Export
from haptic_tracing.core.formats.haptic_scene import read_export, write_export
from haptic_tracing.core.formats.io import catalogue
from haptic_tracing.core.formats.scene.recording import RecordedFrame, Recording
from haptic_tracing.core.formats.tracks.listener_tracks import ListenerTrack, Tracks
from haptic_tracing.core.scene.values import Contact, HapticObject, HapticScene, Listener, Source
from haptic_tracing.core.signals import Sine
from PIL import Image

SCENE = HapticScene(
    objects=(HapticObject("ground", 0.2, 0.9), HapticObject("bench", 0.1, 0.8)),
    contacts=(Contact(("ground", "bench"), ((1, 0, 0), (1, 0, 0))),),
    sources=(Source("hammer", "ground", signal=Sine(60.0)),),
    listeners=(
        Listener("seat", "bench", (1.2, 0, 0.4), "upper_leg.L", radius=0.0),
        Listener("back", "bench", (1.2, 0, 0.9), "upper_back.L", radius=0.0),
    ),
)


@pytest.fixture
def scene_file(tmp_path):
    write_export(Export("bench", SCENE), tmp_path / "bench.json")
    return tmp_path / "bench.json"


def run(capsys, *arguments):
    """The exit code, the JSON, and what is said beside the files and losses."""
    code = main([*(str(argument) for argument in arguments), "--json"])
    out, err = capsys.readouterr()
    lines = [line for line in err.splitlines(True) if not line.startswith(("wrote ", "not in "))]
    return code, out, "".join(lines)


@pytest.mark.slow
@pytest.mark.plugins
def test_a_picture_beside_each_format_that_is_read_back(capsys, scene_file, tmp_path):
    arguments = (
        "export",
        scene_file,
        "--to",
        "wav,haptic,web",
        "--out",
        tmp_path / "out",
        "--seconds",
        "1",
        "--picture",
        "--absolute",
    )
    code, out, err = run(capsys, *arguments)
    assert (code, err) == (0, "")
    pictures = sorted(
        name for name in json.loads(out)["exports"][0]["files"] if name.endswith(".png")
    )
    assert pictures == [str(tmp_path / "out" / f"bench.{name}.png") for name in ("haptic", "wav")]
    with Image.open(pictures[1]) as picture:
        pixels = np.asarray(picture.convert("RGB"), dtype=float)
    width = pixels.shape[1]
    # Red is the difference: none is left of a WAV file of 16 bit.
    red = (pixels[..., 0] > 150) & (pixels[..., 1] < 140) & (pixels[..., 2] < 140)
    assert width > 1000 and red[:, 2 * width // 3 :].any(axis=0).mean() > 0.3
    assert red[:, 2 * width // 3 :].any(axis=1).mean() < 0.1


@pytest.mark.slow
@pytest.mark.plugins
def test_lost_onsets_are_in_the_text_the_json_and_the_picture(capsys, tmp_path):
    """A blow of 2 kHz, which a .haps clip cannot hold, and one of 2 Hz that begins earlier in it, at
    one listener of two (the panel has its own test)."""
    time = np.arange(4 * 8000) / 8000
    blows = [(1.0, 0.8, 2, 0.03), (2.5, 0.5, 2000, 0.02)]
    since = [np.maximum(time - begin, 0) for begin, *_ in blows]
    leg = sum(
        strength * np.exp(-t / decay) * np.sin(2 * np.pi * hertz * t)
        for t, (_, strength, hertz, decay) in zip(since, blows, strict=True)
    )
    listeners = (
        ListenerTrack("seat", "upper_leg.L"),
        ListenerTrack("back", "upper_back.L", np.array([blow[:2] for blow in blows])),
    )
    tracks = Tracks(listeners, 8000, np.stack([0.3 * np.sin(2 * np.pi * 60 * time), leg]))
    write_export(Export("bench", SCENE, tracks), tmp_path / "bench.json", tracks="inline")
    code, out, err = run(
        capsys,
        "export",
        tmp_path / "bench.json",
        "--to",
        "wyvrn",
        "--out",
        tmp_path,
        "--absolute",
        "--picture",
    )
    assert (code, err) == (0, "")
    (printed,) = json.loads(out)["exports"]
    back, seat = printed["listeners"]["wyvrn"]
    assert (back["name"], seat["name"]) == ("back", "seat") and back["level"] > 3
    assert back["missing"] == [2.5] and len(back["invented"]) == 1
    assert not (seat["missing"] or seat["invented"])
    words = printed["losses"]["wyvrn"]
    assert "onsets missing at back: 2.500 s" in words
    assert f"onsets invented at back: {back['invented'][0]:.3f} s" in words
    assert any(
        line.startswith(f"by listener, most lost first: back {back['lost']:.1%}") for line in words
    )
    with Image.open(tmp_path / "bench.wyvrn.png") as picture:
        pixels = np.asarray(picture.convert("RGB"), dtype=int)
    height, width = pixels.shape[0], pixels.shape[1] // 3
    # Dashed lines over the waves of the second listener alone: red where an onset is missing,
    # violet, earlier, where one is invented.
    columns = []
    for colour in ((214, 39, 40), (148, 103, 189)):
        marked = np.abs(pixels[:, :width] - colour).max(axis=2) < 42
        assert not marked[: height // 2].any()
        assert marked.sum(axis=0).max() > 0.02 * height
        columns.append(int(marked.sum(axis=0).argmax()))
    assert 0.25 * width < columns[1] < columns[0] - 0.2 * width


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such terminals")
@pytest.mark.parametrize(("answer", "replaced"), [(b"n\n", False), (b"y\n", True)])
@pytest.mark.plugins
def test_a_terminal_is_asked_before_a_poor_copy_replaces_a_file(tmp_path, answer, replaced):
    noise = np.random.default_rng(0).integers(-9000, 9000, 8000).astype("<i2")
    with wave.open(str(tmp_path / "noise.wav"), "wb") as file:
        file.setparams((1, 2, 8000, 0, "NONE", ""))
        file.writeframes(noise.tobytes())
    target = tmp_path / "noise.hjif"
    target.write_text("what was there")
    master, terminal = os.openpty()
    command = [
        sys.executable,
        "-m",
        "haptic_tracing",
        "convert",
        str(tmp_path / "noise.wav"),
        str(target),
        "--json",
    ]
    with subprocess.Popen(
        command, stdin=terminal, stdout=subprocess.PIPE, stderr=subprocess.PIPE
    ) as child:
        os.write(master, answer)
        out, err = child.communicate(timeout=100)
    os.close(master)
    os.close(terminal)
    assert child.returncode == 0 and b"Replace noise.hjif? [y/N]" in err and b"of the power" in err
    assert (target.read_text() != "what was there") is replaced
    assert json.loads(out)["files"] == ([str(target)] if replaced else [])


@pytest.mark.plugins
def test_export_to_all_formats(capsys, scene_file, tmp_path):
    code, out, err = run(
        capsys,
        "export",
        scene_file,
        "--to",
        "all",
        "--out",
        tmp_path / "out",
        "--seconds",
        "1",
        "--absolute",
    )
    assert (code, err) == (0, "")
    (printed,) = json.loads(out)["exports"]
    files = [tmp_path / name for name in printed["files"]]
    assert all(path.is_file() for path in files) and set(printed["losses"]) == set(
        catalogue.formats()
    )
    for name, listeners in printed["listeners"].items():
        assert {entry["name"] for entry in listeners} == {"seat", "back"}, name
        assert all(
            set(entry) == {"name", "lost", "level", "missing", "invented"} for entry in listeners
        )
    assert set(printed["listeners"]) == set(catalogue.formats()) - {"scene"}
    endings = ".json .wav .hjif .haps .config .haptic .acf .ahap .tact .html .waveform .parametric"
    assert {path.suffix for path in files} == set(endings.split())
    channels = registry.read(tmp_path / "out" / "bench.wav").channels
    assert [channel.name for channel in channels] == ["seat", "back"] and channels[
        0
    ].duration == pytest.approx(1.0, abs=1e-3)
    # The seat is nearer; both feel the gains that propagate prints.
    main(["propagate", str(scene_file)])
    gains = {
        entry["listener"]: entry["gain"] for entry in json.loads(capsys.readouterr().out)["gains"]
    }
    for channel in channels:
        assert np.abs(channel.samples[800:]).max() == pytest.approx(
            gains[channel.name], rel=2e-3, abs=1e-4
        )


@pytest.mark.plugins
def test_all_formats_are_those_that_can_be_written(capsys, tmp_path):
    bare = replace(SCENE, listeners=tuple(replace(item, body_part="") for item in SCENE.listeners))
    write_export(Export("bare", bare), tmp_path / "bare.json")
    code, out, err = run(
        capsys,
        "export",
        tmp_path / "bare.json",
        "--to",
        "all",
        "--out",
        tmp_path / "out",
        "--seconds",
        "0.1",
        "--absolute",
    )
    assert code == 0 and err.count("\n") == 1 and err.startswith("tact: ") and "body part" in err
    (printed,) = json.loads(out)["exports"]
    assert set(printed["losses"]) == set(catalogue.formats()) - {"tact"} and not list(
        (tmp_path / "out").glob("*.tact")
    )
    code, _, err = run(
        capsys,
        "export",
        tmp_path / "bare.json",
        "--to",
        "tact",
        "--out",
        tmp_path / "none",
        "--seconds",
        "0.1",
        "--absolute",
    )
    assert code == 2 and "give one such a body part" in err and not (tmp_path / "none").exists()


def test_export_of_frames_is_as_long_as_they_are(capsys, tmp_path):
    frames = (RecordedFrame(1), RecordedFrame(13, amplitudes={"hammer": 0.0}), RecordedFrame(25))
    write_export(
        Export("timed", SCENE, recording=Recording(24, 1, frames)), tmp_path / "timed.json.gz"
    )
    code, *_ = run(
        capsys,
        "export",
        tmp_path / "timed.json.gz",
        "--to",
        "wav",
        "--out",
        tmp_path,
        "--option",
        "wav.encoding=float32",
    )
    assert code == 0
    (seat, _) = registry.read(tmp_path / "timed.wav").channels
    assert (
        seat.duration == 1.0
        and np.abs(seat.samples[1000:3000]).max() > 0.01
        and not seat.samples[4100:].any()
    )


def test_tracks_in_the_file_are_taken_as_they_are(capsys, scene_file, tmp_path):
    run(
        capsys,
        "export",
        scene_file,
        "--to",
        "scene",
        "--out",
        tmp_path / "a",
        "--option",
        "scene.tracks=wav",
        "--seconds",
        "1",
    )
    assert (
        read_export(tmp_path / "a" / "bench.json").tracks is None
    )  # nobody asked for tracks to be rendered
    run(
        capsys,
        "export",
        scene_file,
        "--to",
        "scene,wav",
        "--absolute",
        "--out",
        tmp_path / "b",
        "--option",
        "scene.tracks=inline",
        "--seconds",
        "1",
    )
    with_tracks = read_export(tmp_path / "b" / "bench.json")
    assert with_tracks.tracks.count == 8000
    run(
        capsys,
        "export",
        tmp_path / "b" / "bench.json",
        "--to",
        "wav",
        "--out",
        tmp_path / "c",
        "--absolute",
        "--seconds",
        "9",
    )
    assert (tmp_path / "b" / "bench.wav").read_bytes() == (
        tmp_path / "c" / "bench.wav"
    ).read_bytes()


@pytest.mark.plugins
def test_losses_alone_write_nothing(capsys, scene_file, tmp_path):
    code, out, _ = run(
        capsys,
        "export",
        scene_file,
        "--to",
        "hjif,tact",
        "--out",
        tmp_path / "out",
        "--losses",
        "--seconds",
        "0.1",
        "--absolute",
    )
    assert (
        code == 0
        and set(json.loads(out)["exports"][0]["losses"]) == {"hjif", "tact"}
        and not (tmp_path / "out").exists()
    )


@pytest.mark.slow
@pytest.mark.plugins
def test_convert_between_every_pair_of_kinds(capsys, scene_file, tmp_path):
    run(
        capsys,
        "export",
        scene_file,
        "--to",
        "wav,hjif,haptic,ahap,wyvrn",
        "--out",
        tmp_path,
        "--seconds",
        "0.5",
    )
    sources = [
        "bench.wav",
        "bench.hjif",
        "bench.seat.haptic",
        "bench.seat.ahap",
        "bench/bench.seat.haps",
    ]
    for source in sources:
        for suffix in (
            ".wav",
            ".hjif",
            ".haptic",
            ".ahap",
            ".haps",
            ".html",
            ".tact",
        ):
            target = tmp_path / f"converted{suffix}"
            code, out, err = run(capsys, "convert", tmp_path / source, target)
            if suffix == ".tact" and ".seat" in source:  # of a leg, where no device is worn
                assert code == 2 and "give one such a body part" in err
                continue
            assert code == 0, (source, suffix, err)
            assert json.loads(out)["files"]
    code, *_ = run(capsys, "convert", tmp_path / "bench.hjif", tmp_path / "again.wav")
    first, again = (
        registry.read(tmp_path / name).channels[0] for name in ("bench.wav", "again.wav")
    )
    assert again.body_part == "upper_leg.L"
    np.testing.assert_allclose(
        again.samples[400:3600], first.samples[400:3600], atol=0.1 * np.abs(first.samples).max()
    )


def test_convert_a_scene_packs_and_unpacks(capsys, scene_file, tmp_path):
    run(capsys, "convert", scene_file, tmp_path / "packed.json.gz")
    run(capsys, "convert", tmp_path / "packed.json.gz", tmp_path / "again.json")
    assert (tmp_path / "again.json").read_bytes() == scene_file.read_bytes()


@pytest.mark.plugins
def test_what_is_wrong_is_said_in_one_line(capsys, scene_file, tmp_path):
    broken = tmp_path / "broken.json"
    broken.write_text(
        '{"format": "haptic-scene", "version": "1.1", "objects": [{"name": "a", "kappa": 2, '
        '"rho": 1}]}'
    )
    silent = tmp_path / "silent.json"
    write_export(Export("silent", HapticScene(SCENE.objects)), silent)
    out = ["--out", tmp_path / "out"]
    cases = [
        (
            ["export", broken, "--to", "wav", *out],
            f"{broken}: /objects/0/kappa: must be at most 1, got 2",
        ),
        (
            ["export", tmp_path / "gone.json", "--to", "wav", *out],
            f"{tmp_path / 'gone.json'}: No such file or directory",
        ),
        (["export", silent, "--to", "wav", *out], "there is no listener"),
        (
            ["export", scene_file, "--to", "midi", *out],
            "format 'midi' is unknown: use one of scene, wav",
        ),
        (
            ["export", scene_file, "--to", "wav", *out, "--option", "wav.speed=1"],
            "wav.speed=1: expected FORMAT.OPTION=VALUE with one of",
        ),
        (
            ["export", scene_file, "--to", "wav", *out, "--option", "wav.encoding=mp3"],
            "wav.encoding=mp3: must be one of pcm16, float32, got 'mp3'",
        ),
        (
            ["export", scene_file, "--to", "hjif", *out, "--option", "hjif.error=many"],
            "hjif.error=many: must be a number, got 'many'",
        ),
        (
            ["export", scene_file, "--to", "wav", *out, "--seconds", "nan"],
            "--seconds: must be above 0",
        ),
        (
            ["export", scene_file, "--to", "wav", *out, "--sample-rate", "7"],
            "sample_rate: must be from 100",
        ),
        (["export", scene_file, scene_file], "one scene or Blender file at a time"),
        (["export", scene_file, "--frames", "1:9"], "--frames: only for a Blender file"),
        (["convert", scene_file, tmp_path / "a.wav"], "to render it, use export"),
        (["convert", broken, tmp_path / "a.json"], f"{broken}: /objects/0/kappa"),
        (["convert", tmp_path / "a.mid", tmp_path / "a.wav"], "can't be imported"),
        (["convert", tmp_path / "a.wav", tmp_path / "a.mid"], "the ending must be one of .wav"),
    ]
    for arguments, expected in cases:
        code, printed, error = run(capsys, *arguments)
        assert code == 2 and printed == "" and expected in error, (arguments, error)
        assert error.count("\n") == 1 and error.endswith("\n") and "Traceback" not in error
    assert not list((tmp_path / "out").glob("*")) if (tmp_path / "out").exists() else True


def test_the_program_itself_exits_with_2(tmp_path):
    """As a process: exit code, one line, nothing on stdout; also for a file name with a line break
    in it."""
    for arguments in (["propagate", "gone\nfile.json"], ["nonsense"], []):
        command = [sys.executable, "-m", "haptic_tracing", *arguments]
        done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, check=False)
        assert done.returncode == 2 and done.stdout == "" and done.stderr.count("\n") == 1, (
            done.stderr
        )


def test_asking_for_help_loads_nothing_heavy(tmp_path):
    heavy = {"fcl", "scipy", "networkx", "bpy", "hid", "hidraw"}
    code = (
        "import sys; from haptic_tracing.command_line import main; main(['--help']); "
        f"print(sorted({heavy} & set(sys.modules)))"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, cwd=tmp_path, check=True
    )
    assert done.stdout.rstrip().endswith("[]")
