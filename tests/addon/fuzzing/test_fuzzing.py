"""Random inputs for everything that reads; `make fuzz` tries a million. What once got through is
tried again by name."""

from __future__ import annotations

import random
import warnings
from collections import Counter

import pytest

from .inputs import CRASHERS, STORED, changed, targets

TARGETS = targets()


@pytest.mark.parametrize("name", sorted(path.name for path in CRASHERS.iterdir()))
def test_what_once_got_through_does_no_more(tmp_path, name):
    assert TARGETS[name.rpartition(".")[0]].run((CRASHERS / name).read_bytes(), tmp_path) is False


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(TARGETS))
def test_inputs_good_and_changed_are_read_or_refused_in_one_message(tmp_path, name):
    target, generator = TARGETS[name], random.Random(name)
    inputs = [*dict.fromkeys(target.seeds), *(changed(target.seeds, generator) for _ in range(100))]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", SyntaxWarning)
        outcomes = Counter(target.run(content, tmp_path) for content in inputs)
    assert (
        outcomes[True] + outcomes[False] == len(inputs) and min(outcomes[True], outcomes[False]) > 0
    ), outcomes


@pytest.mark.parametrize(
    ("kind", "text"),
    [(kind, seed.decode()) for kind in STORED for seed in TARGETS[f"stored-{kind}"].seeds],
)
def test_what_is_changed_is_good(kind, text):
    reader = STORED[kind][0]
    read = reader(text)
    assert read is not None
