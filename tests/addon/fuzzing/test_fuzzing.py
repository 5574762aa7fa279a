"""Random inputs for everything that reads; `make fuzz` tries a million. What once got through is tried again by name."""

from __future__ import annotations

import random
import warnings
from functools import partial

import pytest

from .inputs import CRASHERS, STORED, changed, targets

TARGETS = targets()


@pytest.mark.parametrize("name", sorted(path.name for path in CRASHERS.iterdir()))
def test_what_once_got_through_does_no_more(tmp_path, name):
    TARGETS[name.rpartition(".")[0]].run((CRASHERS / name).read_bytes(), tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(TARGETS))
def test_changed_inputs_are_read_or_refused_in_one_message(tmp_path, name):
    generator = random.Random(name)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", SyntaxWarning)
        for _ in range(100):
            TARGETS[name].run(changed(TARGETS[name].seeds, generator), tmp_path)


@pytest.mark.parametrize(("kind", "text"), [(kind, seed.decode()) for kind in STORED for seed in TARGETS[f"stored-{kind}"].seeds])
def test_what_is_changed_is_good(kind, text):
    reader = STORED[kind][0]
    read = reader(text)
    assert read is not None and read != (partial(reader)("{}") if kind != "impacts" else None)
