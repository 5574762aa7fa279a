"""Files appear whole or not at all, under names that every system takes, and never outside the
chosen folder."""

import errno
import json
import os
import signal
import subprocess
import sys
import threading
from pathlib import Path

import numpy as np
import pytest
from haptic_tracing.core.formats import registry
from haptic_tracing.core.formats.export import Export
from haptic_tracing.core.formats.io import atomic, catalogue
from haptic_tracing.core.formats.io.file_names import file_stem, file_stems
from haptic_tracing.core.formats.tracks.listener_tracks import ListenerTrack, Tracks
from haptic_tracing.core.scene.values import HapticObject, HapticScene
from hypothesis import given
from hypothesis import strategies as st
from written_scenes import read_scene, write_scene

# Names that Windows keeps for devices, with any ending (Microsoft: Naming Files, Paths, and
# Namespaces).
RESERVED = {
    "con",
    "prn",
    "aux",
    "nul",
    "conin$",
    "conout$",
    *(f"{port}{digit}" for port in ("com", "lpt") for digit in "0123456789¹²³"),
}
FORBIDDEN = set('<>:"/\\|?*') | {chr(code) for code in range(32)}


@given(st.text(st.characters(), max_size=300))
def test_every_name_becomes_a_file_name_that_windows_takes(name):
    stem = file_stem(name)
    assert (
        stem
        and not FORBIDDEN & set(stem)
        and not stem.startswith((" ", "-"))
        and not stem.endswith((" ", "."))
    )
    assert stem.split(".")[0].rstrip(" ").casefold() not in RESERVED
    assert stem not in (".", "..") and Path(stem).name == stem
    assert len(stem.encode()) <= 255
    assert file_stem(stem) == stem


@pytest.mark.parametrize(
    ("name", "stem"),
    [
        ("hand.L", "hand.L"),
        ("../../etc/passwd", "_.._etc_passwd"),
        ("..", "_"),
        ("", "_"),
        ("C:\\Windows", "C_Windows"),
        ("NUL", "_NUL"),
        ("com1.hjif", "_com1.hjif"),
        ("COM¹", "_COM¹"),
        ("common", "common"),
        ("line\nbreak", "line_break"),
        ("trailing. . ", "trailing"),
        ("-rf", "_-rf"),
        ("Ünïcödé 手", "Ünïcödé 手"),
        ("e\u0301", "é"),
        ("a\u202egnp.exe", "a_gnp.exe"),
    ],
)
def test_names(name, stem):
    assert file_stem(name) == stem


def test_names_that_differ_in_case_alone_are_told_apart():
    assert file_stems(["a", "A", "a", "b", "a_2"]) == ["a", "A_2", "a_3", "b", "a_2_2"]


@pytest.mark.slow
@given(st.lists(st.text(max_size=6), max_size=8))
def test_file_stems_are_unique_for_every_file_system(names):
    stems = [stem.casefold() for stem in file_stems(names)]
    assert len(set(stems)) == len(stems) == len(names)


@pytest.mark.parametrize("name", [form for form in catalogue.formats() if form != "scene"])
def test_hostile_names_stay_in_the_folder(tmp_path, name):
    listeners = (
        ListenerTrack("../../up", "hand.L"),
        ListenerTrack("NUL", "ear.L"),
        ListenerTrack("nul", "belly"),
    )
    tracks = Tracks(listeners, 8000, np.zeros((3, 800)))
    folder = tmp_path / "chosen"
    folder.mkdir()
    files = registry.write(name, Export("../..//evil\x00", tracks=tracks), folder).files
    assert files and len(set(files)) == len(files)
    assert all(path.resolve().is_relative_to(folder.resolve()) and path.is_file() for path in files)
    assert list(tmp_path.iterdir()) == [folder]


@pytest.mark.parametrize(
    "failure",
    [OSError(errno.ENOSPC, "No space left on device"), KeyboardInterrupt(), MemoryError()],
)
def test_a_failure_while_writing_leaves_what_was_there(tmp_path, failure):
    path = tmp_path / "scene.json"
    path.write_text("what was there")
    with pytest.raises(type(failure)), atomic.atomic_file(path) as file:
        file.write(b"half of")
        raise failure
    assert path.read_text() == "what was there" and list(tmp_path.iterdir()) == [path]


WRITER = """
import os, resource, signal, sys
import numpy as np
from haptic_tracing.core.formats import registry
from haptic_tracing.core.formats.export import Export
from haptic_tracing.core.formats.tracks.listener_tracks import ListenerTrack, Tracks
from haptic_tracing.core.scene.values import HapticObject, HapticScene

noise = np.random.default_rng(0).normal(0, 0.1, (2, 80_000)).clip(-1, 1)
tracks = Tracks((ListenerTrack("hand", "hand.L", [[0.5, 0.5]]), ListenerTrack("ear", "ear.L")), 8000, noise)
sys.dont_write_bytecode = True  # else modules imported under the limit leave cut files in the cache
export = Export("scene", HapticScene((HapticObject("a", 0, 1),)), tracks)
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
for case in sys.argv[1:]:
    name, most, folder = case.split(" ", 2)
    if os.fork() == 0:
        resource.setrlimit(resource.RLIMIT_FSIZE, (int(most), int(most)))
        try:
            registry.write(name, export, folder, {"tracks": "inline"} if name == "scene" else {})
        except OSError as error:
            os._exit(REFUSED)
        os._exit(0)
    print(os.waitstatus_to_exitcode(os.wait()[1]))
"""
REFUSED = 77


@pytest.fixture(scope="module")
def full_disks(tmp_path_factory):
    """The folder and the exit code of a process for each format and each largest file that the
    system allows it."""
    cases = {
        (name, most): tmp_path_factory.mktemp("full")
        for name in catalogue.formats()
        for most in (1, 1000)
    }
    command = [
        sys.executable,
        "-c",
        WRITER.replace("REFUSED", str(REFUSED)),
        *(f"{n} {m} {f}" for (n, m), f in cases.items()),
    ]
    codes = map(
        int, subprocess.run(command, capture_output=True, text=True, check=True).stdout.split()
    )
    return {case: (folder, code) for (case, folder), code in zip(cases.items(), codes, strict=True)}


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "fork"), reason="only Unix can refuse to let a file grow")
@pytest.mark.parametrize("name", list(catalogue.formats()))
@pytest.mark.parametrize("most", [1, 1000])
def test_a_disk_that_takes_no_more_gets_no_half_file(full_disks, name, most):
    """The system itself refuses to let any file grow beyond ``most`` bytes, in the midst of
    writing."""
    folder, code = full_disks[name, most]
    left = [path for path in folder.rglob("*") if path.is_file()]
    # What is there is whole: small side files, written before the large one that the disk did not
    # take.
    assert code == REFUSED and all(path.suffix != ".part" for path in left), (left, code)
    for path in left:
        assert json.loads(path.read_bytes())


KILLED = """
import os, signal, sys
from haptic_tracing.core.formats.io.atomic import atomic_file

with atomic_file(sys.argv[1]) as file:
    file.write(b"half of it" * 100_000)
    os.kill(os.getpid(), signal.SIGKILL)
"""


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="Windows has no such signal")
def test_a_crash_while_writing_leaves_what_was_there(tmp_path):
    path = tmp_path / "scene.json"
    path.write_text("what was there")
    assert (
        subprocess.run([sys.executable, "-c", KILLED, str(path)], check=False).returncode
        == -signal.SIGKILL
    )
    assert path.read_text() == "what was there"
    assert all(
        other.name.startswith(".") and other.suffix == ".part"
        for other in tmp_path.iterdir()
        if other != path
    )


HELD = """
import os, signal, sys, time
from pathlib import Path
from haptic_tracing.core.formats.io.atomic import atomic_file
from haptic_tracing.core.formats.io.atomic import staging

folder = Path(sys.argv[1])
with staging(folder) as place, atomic_file(folder / "scene.json") as file:
    (place.folder / "half.wav").write_bytes(bytes(10))
    file.write(b"half")
    print("written", flush=True)
    sys.stdin.read()
    os.kill(os.getpid(), signal.SIGKILL)
"""


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="Windows has no such signal")
def test_what_a_killed_export_left_goes_with_the_next_one(tmp_path):
    """What another process is still writing stays."""
    child = subprocess.Popen(
        [sys.executable, "-c", HELD, str(tmp_path)], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    )
    with child:
        assert child.stdout.readline() == b"written\n"
        (tmp_path / "mine.part").write_text("no name of ours")
        unfinished = {path for path in tmp_path.iterdir() if path.name.startswith(".")}
        assert len(unfinished) == 2
        registry.write("scene", Export("first", HapticScene()), tmp_path)
        assert unfinished < set(tmp_path.iterdir())
        child.stdin.close()
        child.wait(timeout=60)
    assert child.returncode == -signal.SIGKILL and unfinished < set(tmp_path.iterdir())
    registry.write("scene", Export("second", HapticScene()), tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        "first.json",
        "mine.part",
        "second.json",
    ]


def test_a_folder_in_the_way(tmp_path):
    (tmp_path / "scene.json").mkdir()
    with pytest.raises(OSError):
        write_scene(HapticScene(), tmp_path / "scene.json")
    assert [path.name for path in tmp_path.iterdir()] == ["scene.json"]


def test_a_reader_sees_the_old_file_or_the_new_one(tmp_path):
    path = tmp_path / "scene.json"
    scenes = [
        HapticScene(tuple(HapticObject(f"{version}.{k}", 0, 1) for k in range(200)))
        for version in range(8)
    ]
    write_scene(scenes[0], path)

    def keep_writing():
        for scene in scenes:
            write_scene(scene, path)

    thread = threading.Thread(target=keep_writing)
    thread.start()
    while thread.is_alive():
        assert read_scene(path) in scenes
    thread.join()
    assert read_scene(path) == scenes[-1]


def test_errors_name_the_file_and_not_the_hidden_one_on_the_way_to_it(tmp_path):
    for write in (atomic.write_bytes, lambda path, data: atomic.write_text(path, [data.decode()])):
        with pytest.raises(OSError) as caught:
            write(tmp_path / "gone" / "scene.json", b"x")
        assert caught.value.filename == str(tmp_path / "gone" / "scene.json")
    with pytest.raises(OSError) as caught, atomic.staging(tmp_path) as place:
        (place.folder / "track.wav").write_bytes(b"x")
        (place.folder / "track.wav" / "more.wav").write_bytes(b"x")
    assert caught.value.filename == str(tmp_path / "track.wav" / "more.wav")
