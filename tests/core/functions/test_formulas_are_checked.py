"""The check of a designer's formula: what is wrong and where, whatever is typed."""

import numpy as np
import pytest
from haptic_tracing.core.message import sentence
from haptic_tracing.core.run_time import Scene
from haptic_tracing.core.scene.functions import Expression, check_expression, excerpt
from haptic_tracing.core.scene.functions.expression import MAX_LENGTH
from haptic_tracing.core.scene.values import Contact, HapticObject
from hypothesis import given, settings
from hypothesis import strategies as st


def _check(source, **contact):
    return check_expression(source, **contact)


@pytest.mark.parametrize(
    "source",
    [
        "x * exp(-0.2 * d)",
        "exp(-d)",
        "x * min(1, 1 / (1 + d))",
        "where(d < 2, x, 0.5 * x)",
        "(1 - kappa) * rho",
    ],
)
def test_good_formulas_have_nothing_wrong(source):
    assert _check(source) is None


@pytest.mark.parametrize(
    ("source", "word"),
    [
        ("x * exp(-q * d)", "q"), ("  x * foo(d)", "foo"), ("x * exp(-d) + open", "open"), ("x * d.real", "d.real"), ("x * [1]", "[1]"),
        ("x * 'µ' * y", "'µ'"), ("0 * (d + kappa) * ö", "ö"), ("exp(d, d)", "exp"), ("x * 1e999", "1e999"), ("1 + where(d, 1, 2)", "where"),
    ],
)  # fmt: skip
def test_the_column_is_that_of_the_word_that_is_wrong(source, word):
    finding = _check(source)
    assert not finding.usable
    assert finding.column == source.index(word), finding


@pytest.mark.parametrize(
    ("source", "column"), [("x * exp(", 7), ("x * ", 3), (" x +", 4), ("", 0), ("x * * d", 4)]
)
def test_what_is_not_finished_is_marked_near_its_end(source, column):
    assert abs(_check(source).column - column) <= 1


def test_division_by_zero_is_found_without_running_it():
    finding = _check("x / d")
    assert "no finite value at 0 m" in sentence(finding.message)
    assert finding.column is None
    assert "negative at" in sentence(_check("x * (1 - d)").message)


@pytest.mark.parametrize(
    ("formula", "words"),
    [
        ("x * (1 + d)", "1 at 0.001 m"),
        ("x * kappa * 2", "2 at 0 m (κ 1, ρ 0)"),
        ("x * min(1, 0.5 + d)", "rises to 0.501 at 0.001 m"),
        ("0.5 * x * (1 + 0.5 * sin(d / 100))", "rises to"),
        ("where(d > 999, 1.5, 1) * x", "1.5 at 1e+03 m"),
    ],
)
def test_gains_that_exceed_1_or_rise_are_refused_with_object_and_place(formula, words):
    assert words in sentence(_check(formula).message)
    assert not _check(formula).usable
    with pytest.raises(ValueError, match=r"^expression: .* m \(κ"):
        HapticObject("o", 0.1, 0.9, Expression(expression=formula))
    written = {"function": "expression", "expression": formula}
    with pytest.raises(ValueError, match="/objects/0") as error:
        Scene(objects=[{"name": "plate", "kappa": 0.1, "rho": 0.9, "propagation": written}])
    assert words in str(error.value)


def test_a_contact_may_rise_but_not_exceed_1():
    contact = Contact(("a", "b"), ((0, 0, 0),) * 2, Expression(expression="min(1, 0.5 + d)"))
    assert contact.transmission.gain(np.array([0.0, 9.0]), 0, 1, 0.1).tolist() == [0.5, 1.0]
    with pytest.raises(ValueError, match=r"expression: .*2 at 0 m"):
        Contact(("a", "b"), ((0, 0, 0),) * 2, Expression(expression="2 * x"))


def test_what_exceeds_1_where_it_is_not_checked_counts_as_1():
    late = Expression(expression="where(d > 2000, 3, 1) * x")
    assert HapticObject("o", 0.1, 0.9, late).propagation.gain(np.array([3e3]), 0, 1, 0.1) == 1.0


def test_contact_values_are_zero_inside_an_object():
    finding = _check("x * exp(-area)")
    assert finding.usable
    assert finding.column == 9
    assert _check("x * exp(-area)", on_contact=True) is None


@pytest.mark.parametrize(
    "source",
    [
        "9**9**9**9",
        "(" * 400 + "1" + ")" * 400,
        "-" * 450 + "1",
        "1" + "0" * 450,
        "x" * (MAX_LENGTH + 1),
        "e**e**e**e**e**d",
    ],
)
def test_huge_formulas_are_answered_at_once(source):
    assert _check(source) is not None or _check(source) is None


@settings(derandomize=True, deadline=None, max_examples=300)
@given(st.text(alphabet="xd kappa0123.+-*/()<,expminwhere", max_size=40) | st.text(max_size=40))
def test_any_text_is_either_right_or_told_what_is_wrong(source):
    finding = _check(source)
    if finding is None:
        gains = Expression(expression=source).gain(np.geomspace(1e-3, 100, 50), 0.1, 0.9, 0.1)
        assert np.all(np.isfinite(gains)) and np.all(gains >= 0)
    else:
        assert sentence(finding.message)
        assert finding.column is None or 0 <= finding.column <= len(source)


@settings(derandomize=True, deadline=None)
@given(st.text(min_size=1, max_size=200), st.integers(0, 200), st.integers(5, 60))
def test_the_excerpt_shows_the_character_at_the_column(source, column, width):
    column = min(column, len(source) - 1)
    shown, place = excerpt(source, column, width)
    assert len(shown) <= width
    assert 0 <= place < max(len(shown), 1)
    assert shown[place] == source[column] or shown[place] == "…"
