"""Property-based tests: the same examples on every run, or many more of them from random seeds. And
how the tests spare the processor."""

from __future__ import annotations

import atexit
import gc
import os
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import haptic_tracing
import own_temporary_folder
import pytest
from hypothesis import settings

IS_WORKER = "PYTEST_XDIST_WORKER" in os.environ

# The folders' own conftest files import bpy. Workers have folders of their own: they write
# preferences at the same time.
own_temporary_folder.make(anew=IS_WORKER)

# The matrices are small: threads of BLAS would only wait for each other, at full load. What depends
# on their number sets it itself.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

gc.disable()  # until everything is collected: what is imported stays

settings.register_profile("same examples", derandomize=True, deadline=None, print_blob=True)
settings.load_profile("same examples")


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--times-examples",
        type=int,
        default=1,
        metavar="N",
        help="N times the examples of each property, from random seeds",
    )
    parser.addoption(
        "--stress-seeds",
        type=int,
        default=1,
        metavar="N",
        help="random orders of operations in test_stress.py",
    )
    parser.addoption(
        "--stress-operations", type=int, default=300, metavar="N", help="operations in each of them"
    )


@pytest.fixture(autouse=True)
def temporary_files() -> Iterator[None]:
    """Commands put their process' temporary files into Blender's folder, which a later file may
    remove: tests in the same process go on with their own."""
    before = tempfile.tempdir
    yield
    tempfile.tempdir = before


@pytest.fixture(scope="session")
def shared_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The same folder in all workers, for what is made once."""
    own = tmp_path_factory.getbasetemp()
    folder = (own.parent if IS_WORKER else own) / "shared"
    folder.mkdir(exist_ok=True)
    return folder


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    if not (Path(haptic_tracing.__file__).parent / "plugins").is_dir():
        items[:] = [item for item in items if item.get_closest_marker("plugins") is None]
    if IS_WORKER:
        _put_slow_files_first(items)
    if config.getoption("--times-examples") > 1:
        _take_more_examples(items, config.getoption("--times-examples"))


def _put_slow_files_first(items: list[pytest.Item]) -> None:
    """Of files run side by side the small and fast ones come last, so that none is still going on
    alone when all others have ended."""
    files: dict[Path, list[pytest.Item]] = {}
    for item in items:
        files.setdefault(item.path, []).append(item)

    def order(path: Path) -> tuple[float, int]:
        own = files[path]
        slow = sum(item.get_closest_marker("slow") is not None for item in own)
        return -slow / len(own), -len(own)

    items[:] = [item for path in sorted(files, key=order) for item in files[path]]


def _take_more_examples(items: list[pytest.Item], times: int) -> None:
    changed = set()
    for item in items:
        function = getattr(item, "obj", None)
        if (
            getattr(function, "is_hypothesis_test", False) and function not in changed
        ):  # parametrised tests share their function
            usual = function._hypothesis_internal_use_settings
            function._hypothesis_internal_use_settings = settings(
                usual, max_examples=times * usual.max_examples, derandomize=False
            )
            changed.add(function)


def pytest_collection_finish() -> None:
    """What is imported and collected stays to the end: the garbage collector need not look at it
    again and again."""
    gc.collect()
    gc.freeze()
    gc.enable()
    gc.set_threshold(100_000, 20, 50)


def pytest_sessionfinish() -> None:
    """Commands that ran in this process asked for the add-on to be disabled at its end: their tests
    have done so."""
    if trace := sys.modules.get(
        "haptic_tracing.command_line.trace"
    ):  # Blender may have reloaded the package since, with other functions
        atexit.unregister(trace.unregister)
