"""The JSON form of signals: what it looks like, and one clear error for what is broken or
hostile."""

from __future__ import annotations

import json
from typing import Any

import pytest
from haptic_tracing.core.signals import SIGNAL_KINDS, Sine, ramp, signal_from_dict
from hypothesis import given, settings
from hypothesis import strategies as st


def nested(depth: int) -> dict[str, Any]:
    data: dict[str, Any] = {"signal": "sine"}
    for _ in range(depth):
        data = {"signal": "gain", "of": data}
    return data


def test_form() -> None:
    assert Sine(60).to_dict() == {
        "signal": "sine",
        "frequency": 60.0,
        "amplitude": 1.0,
        "phase": 0.0,
    }
    assert (Sine(ramp(20, 200, 0.5)) * 0.5).to_dict() == {
        "signal": "gain",
        "of": {
            "signal": "sine",
            "frequency": {"times": [0.0, 0.5], "values": [20.0, 200.0]},
            "amplitude": 1.0,
            "phase": 0.0,
        },
        "gain": 0.5,
    }


def test_defaults_may_be_left_out() -> None:
    assert signal_from_dict({"signal": "sine", "frequency": 60, "amplitude": 1.0}) == Sine(60.0)
    assert signal_from_dict({"signal": "sine"}) == Sine()


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (None, ": must be an object"),
        ([], ": must be an object"),
        ({}, "/signal: must be one of "),
        ({"signal": "sinus"}, "/signal: must be one of "),
        ({"signal": ["sine"]}, "/signal: must be one of "),
        ({"signal": "sine", "freq": 3}, "/freq: unknown key of sine"),
        ({"signal": "sine", "frequency": "60"}, "/frequency: must be a number, not str"),
        ({"signal": "sine", "frequency": None}, "/frequency: must be a number, not NoneType"),
        (
            {"signal": "sine", "frequency": float("nan")},
            "/frequency: must be from 0 to 20000, got nan",
        ),
        ({"signal": "sine", "frequency": 10**400}, "/frequency: must be from 0 to 20000, got 1000"),
        (
            {"signal": "sine", "frequency": {"times": [0]}},
            "/frequency: must be a number or have times and values",
        ),
        (
            {"signal": "sine", "frequency": {"times": [0], "values": ["x"]}},
            "/frequency/values: must be a list of numbers",
        ),
        (
            {"signal": "sine", "frequency": {"times": [0, 1], "values": [1]}},
            "/frequency/values: 1 for 2 times",
        ),
        (
            {"signal": "sine", "frequency": {"times": [0], "values": [10**400]}},
            "/frequency/values: must be a list of numbers",
        ),
        (
            {"signal": "sine", "amplitude": {"signal": "sine"}},
            "/amplitude: must be a number, not Sine",
        ),
        ({"signal": "gain"}, "/of: missing"),
        (
            {"signal": "gain", "of": {"signal": "sine", "phase": "a"}},
            "/of/phase: must be a number, not str",
        ),
        ({"signal": "sum", "of": []}, "/of: must be a tuple of at least one signal"),
        (
            {"signal": "sum", "of": [{"signal": "sine"}, {"signal": "noise", "seed": 0.5}]},
            "/of/1/seed: must be a whole number, not 0.5",
        ),
        ({"signal": "sum", "of": [{"signal": "sine"}, 3]}, "/of/1: must be an object"),
        (
            {"signal": "sum", "of": {"signal": "sine"}},
            "/of: must be a tuple of at least one signal",
        ),
        ({"signal": "sampled", "samples": [1, "a"]}, "/samples: must be a list of numbers"),
        ({"signal": "sampled", "samples": [float("inf")]}, "/samples: must be finite"),
        ({"signal": "sampled", "samples": [1], "peak": 3}, "/peak: unknown key of sampled"),
        ({"signal": "loop", "of": {"signal": "sine"}}, "/of: a looped signal must end"),
        (nested(40), ": the signal is too complex"),
        (
            {"signal": "sum", "of": [{"signal": "sine"}] * 2000},
            "/of/999: the signal is too complex",
        ),
        pytest.param(
            {"signal": "sampled", "samples": [0] * 4_000_001},
            "/samples: the signal has more than 4000000 numbers",
            marks=pytest.mark.slow,
        ),
    ],
)
def test_errors_name_the_place(data: object, message: str) -> None:
    with pytest.raises(ValueError) as caught:
        signal_from_dict(data, "/sources/0/signal")
    assert str(caught.value).startswith("/sources/0/signal")
    assert message in str(caught.value)
    assert len(str(caught.value)) < 400


def test_crossfades_cannot_multiply_the_work() -> None:
    data: dict[str, Any] = {"signal": "constant", "duration": 0.1}
    for _ in range(30):
        data = {"signal": "loop", "of": data, "count": 1, "crossfade": 0.01}
    with pytest.raises(ValueError, match="too complex"):
        signal_from_dict(data)


json_values = st.recursive(
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats()
    | st.text(max_size=5)
    | st.sampled_from(list(SIGNAL_KINDS)),
    lambda inner: (
        st.lists(inner, max_size=4)
        | st.dictionaries(
            st.text(max_size=3) | st.sampled_from(["signal", "of", "times", "values"]), inner
        )
    ),
    max_leaves=12,
)


@st.composite
def forms(draw: st.DrawFn) -> dict[str, Any]:
    kind = draw(st.sampled_from(list(SIGNAL_KINDS)))
    names = [
        "frequency",
        "amplitude",
        "phase",
        "duty",
        "of",
        "track",
        "seed",
        "rate",
        "samples",
        "count",
        "crossfade",
        "gain",
        "hold",
    ]
    return {
        "signal": kind,
        **draw(st.dictionaries(st.sampled_from(names), json_values | forms(), max_size=3)),
    }


@pytest.mark.slow
@given(json_values | forms())
@settings(deadline=None, max_examples=200)
def test_any_json_gives_a_signal_or_a_value_error(data: object) -> None:
    try:
        signal = signal_from_dict(data)
    except ValueError as error:
        assert str(error).startswith((":", "/"))
    else:
        json.dumps(signal.to_dict(), allow_nan=False)
