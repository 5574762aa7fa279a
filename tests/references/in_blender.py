"""Blender as a module: every test starts in an empty file with the add-on registered, and the
add-on is unregistered after it."""

from __future__ import annotations

import functools
import os
import sys
import time
import typing
from collections.abc import Callable, Iterator
from importlib import import_module
from pathlib import Path
from typing import Any

# Threads that evaluate a scene of five objects mostly wait for each other, at full load: Blender
# starts as many as this process may use.
_processors = os.sched_getaffinity(0) if hasattr(os, "sched_getaffinity") else set()
if _processors:
    os.sched_setaffinity(0, {min(_processors)})
import bpy

if _processors:
    os.sched_setaffinity(0, _processors)

import haptic_tracing
import pytest
from haptic_tracing.addon import gateway, translations
from haptic_tracing.addon.changes.suspension import suspended
from haptic_tracing.sample_scenes import build_sample
from recording_layout import RecordingLayout

# Tests replace parts of modules: they need the modules themselves, not their stand-ins. Property
# groups are completed before their types are kept below.
for _name in (*gateway.MODULES, "addon.registration.properties"):
    import_module(f"haptic_tracing.{_name}")
# Evaluated and read once, not at the registration in each test: the types of properties, and
# translations.
_hints = typing.get_type_hints
_hints_of = functools.cache(_hints)
typing.get_type_hints = lambda of, *more, **named: (
    _hints(of, *more, **named) if more or named else _hints_of(of)
)
translations.dictionary = functools.cache(translations.dictionary)


@pytest.fixture(scope="session")
def empty_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Blender's own start-up file without its objects, stored uncompressed and in this version's
    layout: it is read in half the time."""
    path = tmp_path_factory.mktemp("start-up") / "empty.blend"
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    bpy.ops.wm.save_as_mainfile(filepath=str(path), compress=False, copy=True)
    return path


@pytest.fixture(autouse=True)
def scene(empty_file: Path) -> Iterator[Any]:
    """The scene of an empty file."""
    bpy.ops.wm.read_homefile(filepath=str(empty_file), load_ui=True)
    haptic_tracing.register()
    yield bpy.context.scene
    haptic_tracing.unregister()


@pytest.fixture
def add_box(scene: Any) -> Callable[..., Any]:
    """Adds a box, as a rigid body where ``body`` is ACTIVE or PASSIVE, haptic with the
    paper's function unless said otherwise."""

    def add(
        name: str,
        location: tuple[float, ...],
        size: tuple[float, ...],
        body: str | None = None,
        haptic: bool = True,
        mass: float = 1.0,
    ) -> Any:
        x, y, z = 0.5, 0.5, 0.5
        corners = [(sx * x, sy * y, sz * z) for sx in (-1, 1) for sy in (-1, 1) for sz in (-1, 1)]
        faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
        mesh = bpy.data.meshes.new(name)
        mesh.from_pydata(corners, [], faces)
        obj = bpy.data.objects.new(name, mesh)
        bpy.context.scene.collection.objects.link(obj)
        obj.location, obj.scale = location, size
        if body is not None:
            with bpy.context.temp_override(object=obj, active_object=obj, selected_objects=[obj]):
                bpy.ops.rigidbody.object_add(type=body)
            obj.rigid_body.mass = mass
        if haptic:
            obj.haptics.function = "haptic_tracing"
            obj.haptics.enabled = True
        return obj

    return add


@pytest.fixture
def add_empty() -> Callable[..., Any]:
    """Adds an empty, as a child of ``parent`` where given."""

    def add(name: str, location: tuple[float, ...] = (0, 0, 0), parent: Any = None) -> Any:
        obj = bpy.data.objects.new(name, None)
        bpy.context.scene.collection.objects.link(obj)
        obj.location = location
        obj.parent = parent
        return obj

    return add


@pytest.fixture
def recording_layout() -> type[RecordingLayout]:
    """The class of a layout that records what is drawn."""
    return RecordingLayout


@pytest.fixture(scope="session")
def sample_files(shared_folder: Path) -> Path:
    """The folder of samples that were built."""
    return shared_folder


@pytest.fixture
def build(sample_files: Path) -> Callable[..., Any]:
    """Opens a sample without tracing it: it is built and saved once."""

    def built(name: str, count: int | None = None) -> Any:
        path = sample_files / f"{name} {count}.blend"
        with suspended():
            if not path.exists():
                bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
                build_sample(name, count)
                made = path.with_stem(f"{name} {count} of {os.getpid()}")
                # Opened again and again.
                bpy.ops.wm.save_as_mainfile(filepath=str(made), compress=False)
                made.replace(path)  # in one step: another worker may open it
            bpy.ops.wm.open_mainfile(filepath=str(path))
        return bpy.context.scene

    return built


@pytest.fixture
def traced() -> Callable[[], Any]:
    """Traces the current frame of the current scene and returns the result (None where there is
    none)."""
    from haptic_tracing.addon.session import session

    def trace() -> Any:
        return session.trace(bpy.context.scene, bpy.context.evaluated_depsgraph_get())

    return trace


ALPHA = {"left": 0.5, "right": 2.0}
"""Attenuations [1/m] of the boxes of `drill_and_hand`."""


@pytest.fixture
def drill_and_hand(
    scene: Any,
    add_box: Callable[..., Any],
    add_empty: Callable[..., Any],
    traced: Callable[[], Any],
) -> Any:
    """A scene of two boxes of 2 m that touch at x = 0; a source at x = -1.8 and a listener at x =
    1.8."""
    for name, x in (("left", -1), ("right", 1)):
        box = add_box(name, (x, 0, 0), (2, 2, 2))
        box.haptics.function, box.haptics.alpha = "exponential", ALPHA[name]
    drill = add_empty("drill", (-0.4, 0, 0), bpy.data.objects["left"])
    drill.haptics.source.enabled, drill.haptics.source.amplitude = True, 0.5
    hand = add_empty("hand", (0.4, 0, 0), bpy.data.objects["right"])
    hand.haptics.listener.enabled, hand.haptics.listener.radius = True, 0.0
    traced()
    return scene


@pytest.fixture
def as_events(monkeypatch: pytest.MonkeyPatch) -> None:
    """Calls handlers as Blender's events do: the worker goes on beside what a test does next, also
    where scripts have to wait for it."""
    from haptic_tracing.addon.session import session

    monkeypatch.setattr(session, "THREADS_ENDANGER_SCRIPTS", False)


@pytest.fixture
def settle(monkeypatch: pytest.MonkeyPatch) -> Callable[[Callable[[], Any]], Any]:
    """Draws again and again until the worker has nothing left to compute, as redraws do in a
    window; returns what was drawn last."""
    from haptic_tracing.addon.session import derived, worker

    submit, jobs = worker.submit, 0

    def counted(*job: Any) -> Any:
        nonlocal jobs
        jobs += 1
        return submit(*job)

    monkeypatch.setattr(derived, "_REST", 0.0)
    monkeypatch.setattr(worker, "submit", counted)

    def settled(draw: Callable[[], Any]) -> Any:
        for _ in range(10):
            while worker._state.pending:
                time.sleep(0.001)
            before, drawn = jobs, draw()
            if jobs == before:
                return drawn
        raise AssertionError("every redraw asks for something new")

    return settled


_status: list[int] = []


def pytest_sessionfinish(session: pytest.Session, exitstatus: int) -> None:
    _status.append(int(exitstatus))


def pytest_unconfigure() -> None:
    """End Python at once where Blender as a module would not: 4.2 crashes after its glTF exporter
    was used, 4.5 may wait for ever for the thread that closes the sound device."""
    if bpy.app.version < (5, 0, 0) and _status:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(_status[-1])
