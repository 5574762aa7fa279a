"""Windows refuses to replace a file that another program has open: the system's own refusal there,
injected elsewhere."""

import sys
import threading
from contextlib import contextmanager
from pathlib import Path

import pytest
from haptic_tracing.core.formats.io import atomic

SHARING_VIOLATION = 32


@pytest.fixture
def opened(monkeypatch):
    """Opens files as programs on Windows do: while they are open, nothing replaces them."""
    in_use = set()
    real = Path.replace

    def replace(path, target):
        if Path(target) in in_use:
            error = PermissionError(13, "Permission denied", str(path))
            error.winerror = SHARING_VIOLATION
            raise error
        return real(path, target)

    if sys.platform != "win32":
        monkeypatch.setattr(Path, "replace", replace)
    monkeypatch.setattr(atomic, "_PAUSE", 0.01)

    @contextmanager
    def opened(path):
        in_use.add(path)
        with path.open("rb"):
            yield
        in_use.discard(path)

    return opened


def test_a_file_that_is_closed_within_a_second_is_replaced(tmp_path, opened):
    path = tmp_path / "scene.json"
    path.write_bytes(b"before")
    closed = threading.Event()

    def holds():
        with opened(path):
            held.set()
            closed.wait(0.03)

    held = threading.Event()
    thread = threading.Thread(target=holds)
    thread.start()
    held.wait()
    atomic.write_bytes(path, b"after")
    thread.join()
    assert path.read_bytes() == b"after" and list(tmp_path.iterdir()) == [path]


def test_a_file_that_stays_open_is_written_beside_it_and_said(tmp_path, opened):
    path = tmp_path / "scene.json"
    path.write_bytes(b"before")
    (tmp_path / "scene (2).json").write_bytes(b"somebody's")
    with (
        opened(path),
        pytest.raises(
            atomic.WrittenBeside,
            match=r"scene.json is open in another program: the new file is scene \(3\).json",
        ),
    ):
        atomic.write_bytes(path, b"after")
    assert {file.name: file.read_bytes() for file in tmp_path.iterdir()} == {
        "scene.json": b"before",
        "scene (2).json": b"somebody's",
        "scene (3).json": b"after",
    }


def staged(target, names):
    """Files on their way to a folder."""
    with atomic.staging(target) as place:
        files = [place.folder / name for name in names]
        for file in files:
            file.parent.mkdir(exist_ok=True)
            file.write_bytes(b"after")
        place.commit(files)


@pytest.mark.parametrize("held", [0, 1, 2])
def test_of_several_files_all_are_replaced_or_none(tmp_path, opened, held):
    names = ["a.hjif", "sounds/b.wav", "c.json"]
    (tmp_path / "sounds").mkdir()
    for name in (names[held], names[0]):
        (tmp_path / name).write_bytes(b"before")
    before = {file: file.read_bytes() for file in tmp_path.rglob("*") if file.is_file()}
    with (
        opened(tmp_path / names[held]),
        pytest.raises(
            atomic.WrittenBeside, match=r"nothing was replaced, the new files are in .*a \(2\)"
        ),
    ):
        staged(tmp_path, names)
    beside = {tmp_path / "a (2)" / name: b"after" for name in names}
    assert {
        file: file.read_bytes() for file in tmp_path.rglob("*") if file.is_file()
    } == before | beside
    staged(tmp_path, names)
    assert all((tmp_path / name).read_bytes() == b"after" for name in names)
    assert not list(tmp_path.glob(".*"))


def test_another_fault_in_the_midst_leaves_all_files_as_they_were(tmp_path, monkeypatch):
    for name in ("a", "b"):
        (tmp_path / name).write_bytes(b"before")
    real = Path.replace

    def replace(path, target):
        if Path(target) == tmp_path / "b" and path.read_bytes() == b"after":
            raise OSError(5, "Input/output error")
        return real(path, target)

    monkeypatch.setattr(Path, "replace", replace)
    with pytest.raises(OSError, match="Input/output error"):
        staged(tmp_path, ["a", "b", "c"])
    assert {file.name: file.read_bytes() for file in tmp_path.iterdir()} == {
        "a": b"before",
        "b": b"before",
    }
