"""The examples in the docstrings of the front door, run as a reader would."""

import doctest

import haptic_tracing as ht
import pytest
from haptic_tracing.core.run_time import result as result_module
from haptic_tracing.core.run_time import run as run_module
from haptic_tracing.core.run_time import scene as scene_module

FOUND = [
    test
    for module in (ht.core.run_time, result_module, run_module, scene_module)
    for test in doctest.DocTestFinder().find(module)
    if test.examples
]


def fault_of(example, **known):
    """What an example prints instead of what it says, "" if it is right; and its names."""
    names = {**vars(scene_module), **known}
    told = []
    runner = doctest.DocTestRunner(optionflags=doctest.IGNORE_EXCEPTION_DETAIL)
    example = doctest.DocTest(example.examples, names, example.name, None, None, None)
    runner.run(example, out=told.append, clear_globs=False)
    return "".join(told), example.globs


@pytest.mark.parametrize("example", FOUND, ids=lambda test: test.name.rpartition("run_time.")[2])
def test_example(example, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    of_class = next(test for test in FOUND if test.name.endswith("scene.Scene"))
    scene = fault_of(of_class)[1]["scene"]
    known = {"open": ht.open, "scene": scene, "run": ht.open(scene)}
    assert fault_of(example, **known)[0] == ""


def test_every_public_function_has_an_example():
    with_example = {test.name for test in FOUND}
    for cls in (ht.Scene, ht.Run):
        for name, member in vars(cls).items():
            if callable(member) and not name.startswith("_"):
                assert f"{cls.__module__}.{cls.__name__}.{name}" in with_example
