"""What every command shares: ``--json``, ``-``, ``--version``, completion, and its page in the
manual."""

import importlib.util
import io
import json
import os
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

import haptic_tracing
import numpy as np
import pytest
from haptic_tracing.command_line import build_parser, main
from haptic_tracing.command_line.arguments import SUBCOMMANDS
from scipy.io import wavfile

ROOT = Path(haptic_tracing.__file__).parent
SCENE = {
    "format": "haptic-scene",
    "version": "1.1",
    "objects": [
        {"name": "ground", "kappa": 0.2, "rho": 0.9},
        {"name": "bench", "kappa": 0.1, "rho": 0.8},
    ],
    "contacts": [{"objects": ["ground", "bench"], "positions": [[1, 0, 0], [1, 0, 0]]}],
    "sources": [
        {
            "name": "drill",
            "object": "ground",
            "position": [0, 0, 0],
            "signal": {"signal": "sine", "frequency": 60},
        }
    ],
    "listeners": [{"name": "seat", "object": "bench", "position": [1, 0, 0.4], "radius": 0}],
}


def program(*arguments, given=b"", folder=None):
    """The program as a process: exit code, what it wrote to stdout and to stderr."""
    command = [sys.executable, "-m", "haptic_tracing", *map(str, arguments)]
    done = subprocess.run(command, input=given, capture_output=True, cwd=folder, check=False)
    return done.returncode, done.stdout, done.stderr.decode()


@pytest.fixture
def piped(monkeypatch):
    """Calls the program in this process, as it takes a second to start another one: exit code,
    what it wrote to stdout and to stderr."""

    def call(*arguments, given=b"", folder=None):
        streams = {name: io.TextIOWrapper(io.BytesIO(), "utf-8") for name in ("stdout", "stderr")}
        streams["stdin"] = io.TextIOWrapper(io.BytesIO(given), "utf-8")
        before = signal.getsignal(signal.SIGTERM)
        with monkeypatch.context() as patch:
            if folder is not None:
                patch.chdir(folder)
            for name, stream in streams.items():
                patch.setattr(sys, name, stream)
            code = main([str(argument) for argument in arguments])
            for name in ("stdout", "stderr"):
                streams[name].flush()
        signal.signal(signal.SIGTERM, before)
        out, err = (streams[name].buffer.getvalue() for name in ("stdout", "stderr"))
        return code, out, err.decode()

    return call


@pytest.fixture
def scene(tmp_path):
    (tmp_path / "bench.json").write_text(json.dumps(SCENE))
    return tmp_path / "bench.json"


@pytest.fixture
def sound(tmp_path):
    wave = 0.5 * np.sin(2 * np.pi * 90 * np.arange(8000) / 8000)
    wavfile.write(tmp_path / "tone.wav", 8000, wave.astype(np.float32))
    return tmp_path / "tone.wav"


def test_a_scene_comes_from_standard_input(scene, piped):
    by_name = piped("propagate", scene)
    by_pipe = piped("propagate", "-", given=scene.read_bytes())
    assert by_name[0] == by_pipe[0] == 0

    def result(text):
        document = json.loads(text)
        document.get("statistics", {}).clear()  # times
        return document

    assert result(by_name[1]) == result(by_pipe[1])


def test_a_fault_in_standard_input_is_said_to_be_there(piped):
    code, out, err = piped("propagate", "-", given=b'{"format": "haptic-scene"')
    assert (code, out) == (2, b"") and err.startswith("standard input: not JSON")
    assert "tmp" not in err and err.count("\n") == 1


@pytest.mark.parametrize("arguments", [["propagate", "-"], ["export", "-", "--to", "wav"]])
def test_sentences_call_it_standard_input(arguments, piped, tmp_path):
    """A listener that nothing reaches: why is said on stderr, with the name of the scene first."""
    given = json.dumps({**SCENE, "contacts": []}).encode()
    code, _, err = piped(*arguments, given=given, folder=tmp_path)
    lines = err.splitlines()
    assert code == 0 and any("'seat' feels nothing" in line for line in lines)
    assert all(line.startswith("standard input: ") and "tmp" not in line for line in lines)


@pytest.mark.slow
def test_nothing_of_a_pipe_is_left_when_it_is_ended(scene, tmp_path):
    """Files on their way to standard output are in the one temporary folder of the run. It ends
    while it waits for somebody to read its 3 MB."""
    (tmp_path / "temporary").mkdir()
    environment = {**os.environ, "TMPDIR": str(tmp_path / "temporary")}
    command = [sys.executable, "-m", "haptic_tracing", "export", "-", "--to", "wav", "--out", "-"]
    with subprocess.Popen(
        [*command, "--seconds", "20"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        env=environment,
    ) as child:
        child.stdin.write(scene.read_bytes())
        child.stdin.close()
        deadline = time.monotonic() + 60
        while not any((tmp_path / "temporary").rglob("*.wav*")) and time.monotonic() < deadline:
            assert child.poll() is None, child.stderr.read()
            time.sleep(0.01)
        child.terminate()
        child.stdout.read()
        child.wait(60)
    left = [path for path in (tmp_path / "temporary").iterdir() if "haptic" in path.name]
    assert child.returncode == 143 and not left


def test_a_pipe_of_three_programs_is_what_files_give(scene, piped, tmp_path):
    exported = ("--to", "wav", "--seconds", "0.5", "--option", "wav.encoding=float32")
    assert piped("export", scene, *exported, "--out", tmp_path)[0] == 0
    code, wave, _ = program("export", "-", *exported, "--out", "-", given=scene.read_bytes())
    assert code == 0 and wave == (tmp_path / "bench.wav").read_bytes()
    to = ("--to", "wav", "--option", "wav.encoding=float32")
    code, same, _ = program("convert", "-", "-", "--from", "wav", *to, given=wave)
    samples = [data[data.index(b"data") :] for data in (wave, same)]
    assert code == 0 and samples[0] == samples[1]


@pytest.mark.plugins
def test_several_files_do_not_fit_into_one_pipe(scene, piped):
    code, out, err = piped("export", scene, "--to", "wav,hjif", "--out", "-", "--seconds", "0.1")
    assert (code, out) == (2, b"") and "name a folder" in err


def test_a_pipe_needs_a_format(sound, piped):
    code, _, err = piped("convert", "-", "out.hjif", given=sound.read_bytes())
    assert code == 2 and "--from" in err


@pytest.mark.parametrize(
    ("arguments", "given", "message"),
    [
        (["--from", "wav"], None, "device 'no such pad' is not connected"),
        (["--from", "wav"], b"RIFF", "standard input: "),
        ([], None, "standard input: say its format by --from"),
    ],
)
def test_what_is_played_comes_from_a_pipe(sound, piped, arguments, given, message):
    """It is read before a device is looked for."""
    given = sound.read_bytes() if given is None else given
    code, out, err = piped("play", "-", "--device", "no such pad", *arguments, given=given)
    assert (code, out) == (2, b"") and message in err and err.count("\n") == 1


def test_a_sound_becomes_a_signal_in_a_pipe(sound, piped, tmp_path):
    code, text, _ = piped(
        "convert", "-", "-", "--from", "wav", "--to", "signal", given=sound.read_bytes()
    )
    assert piped("convert", sound, tmp_path / "signal.json")[0] == 0
    assert code == 0
    assert json.loads(text) == json.loads((tmp_path / "signal.json").read_text())


@pytest.mark.parametrize(
    "name",
    [
        *("convert", "devices", "export", "propagate"),
        pytest.param("sample", marks=pytest.mark.slow),
    ],
)
def test_with_json_stdout_is_one_object(name, scene, sound, piped, tmp_path):
    """Blender's own lines would be beside it in a process alone."""
    arguments = {
        "convert": [sound, tmp_path / "signal.json"],
        "devices": ["encode", "dualsense", "--left", "0.5"],
        "export": [scene, "--to", "wav", "--out", tmp_path, "--seconds", "0.1"],
        "propagate": [scene],
        "sample": ["rails", "--output", tmp_path / "rails.blend", "--no-bake"],
    }.get(name, [])
    call = program if name == "sample" else piped
    code, out, err = call(name, *arguments, "--json", folder=tmp_path)
    assert code == 0 and isinstance(json.loads(out), dict), err


@pytest.mark.slow
def test_blenders_own_lines_are_not_in_the_result(command, tmp_path, capsys):
    """Blender prints on the process' stdout, also while a file is opened and a bake is played."""
    import bpy
    from haptic_tracing.sample_scenes import build_sample

    build_sample("hammer_nail")
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "hammer.blend"))
    code, out, err = program(
        *("trace", tmp_path / "hammer.blend", "--start", 1, "--end", 20, "--no-picture", "--json"),
        *("--out", tmp_path),
    )
    result = json.loads(out)
    assert code == 0 and result["frame"] == 20 and result["gains"], err
    assert [Path(name).name for name in result["files"]] == ["hammer.json", "hammer.wav"]
    code, out, err = program(
        "export", tmp_path / "hammer.blend", "--frames", "1:10", "--out", tmp_path
    )
    assert code == 0, err
    assert all(
        line.startswith((b"wrote ", b"replaced ", b"not in ")) for line in out.splitlines()
    ), out
    capsys.readouterr()
    command("export", tmp_path / "hammer.blend", "--frames", "1:10", "--json", "--out", tmp_path)
    (export,) = json.loads(capsys.readouterr().out)["exports"]
    # hammer.wav, and hammer.wav.json, which describes it
    assert export["files"][0] == str(tmp_path / "hammer.wav")


def test_the_version_is_said(capsys):
    assert main(["--version"]) == 0
    assert capsys.readouterr().out == f"haptic-tracing {haptic_tracing.__version__}\n"


@pytest.mark.parametrize("shell", ["bash", "zsh", "tcsh"])
def test_shells_complete_commands(shell, capsys):
    assert main(["--print-completion", shell]) == 0
    text = capsys.readouterr().out
    assert all(name in text for name in SUBCOMMANDS)


def test_bash_accepts_its_completion(tmp_path, capsys):
    main(["--print-completion", "bash"])
    script = capsys.readouterr().out + (
        '\nCOMP_WORDS=(haptic-tracing pro) COMP_CWORD=1\n_shtab_haptic_tracing\necho "${COMPREPLY[@]}"\n'
    )
    done = subprocess.run(["bash", "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["propagate"]


@pytest.mark.plugins
def test_the_manual_is_that_of_the_arguments():
    specification = importlib.util.spec_from_file_location(
        "write_command_pages", ROOT / "docs" / "write_command_pages.py"
    )
    writer = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(writer)
    written = {path.stem: path.read_text() for path in (ROOT / "docs" / "commands").glob("*.md")}
    assert written == writer.pages(), "run python docs/write_command_pages.py"


@pytest.mark.parametrize("name", SUBCOMMANDS)
def test_the_example_in_the_manual_is_a_call(name):
    words = SUBCOMMANDS[name].example.partition(" <")[0].split()
    assert words[:2] == ["haptic-tracing", name]
    assert build_parser().parse_args(words[1:]).command == name


def test_a_mistyped_command_gets_the_near_one(capsys):
    assert main(["exprot"]) == 2 and "did you mean export?" in capsys.readouterr().err


def test_stdout_is_utf_8_whatever_the_code_page(tmp_path):
    place = {"object": "床", "position": [0, 0, 0]}
    scene = {
        "format": "haptic-scene",
        "version": "1.1",
        "objects": [{"name": "床", "kappa": 0.1, "rho": 0.9}],
        "sources": [{"name": "source", **place}],
        "listeners": [{"name": "手", **place}],
    }
    (tmp_path / "one.json").write_text(json.dumps(scene))
    done = subprocess.run(
        [sys.executable, "-m", "haptic_tracing", "propagate", str(tmp_path / "one.json")],
        capture_output=True,
        env={**os.environ, "PYTHONIOENCODING": "cp1252", "PYTHONUTF8": "0"},
    )
    assert done.returncode == 0 and "手" in done.stdout.decode("utf-8")


def test_a_port_in_use_says_what_to_do(capsys, tmp_path):
    scene = {"format": "haptic-scene", "version": "1.1", "objects": []}
    (tmp_path / "one.json").write_text(json.dumps(scene))
    with socket.create_server(("127.0.0.1", 0)) as taken:
        address = f"127.0.0.1:{taken.getsockname()[1]}"
        code = main(["serve", str(tmp_path / "one.json"), "--listen", address])
    err = capsys.readouterr().err
    assert code == 2 and "port is in use" in err and "HOST:0" in err
