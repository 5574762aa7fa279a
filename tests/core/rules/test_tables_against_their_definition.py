"""Which row of a table counts for a pair of objects, against the order as it is defined, worked out
pair by pair."""

import itertools

import pytest
from haptic_tracing.core.scene.rule_table import Rule, RuleTable, Side

ANVIL, HAMMER, BENCH = ("Anvil", "Steel"), ("Hammer.001", "Steel"), ("Bench [old]", "Wood")

# From the least specific side to the most specific one, of those that fit the anvil.
SIDES = (
    Side(),
    Side(material="St*"),
    Side(material="Steel"),
    Side(object="Anv?l"),
    Side(object="Anvil"),
)


def table(*sides):
    return RuleTable(tuple(Rule(between, number) for number, between in enumerate(sides)))


@pytest.mark.parametrize(("weak", "strong"), list(itertools.combinations(range(5), 2)))
def test_the_more_specific_row_counts_wherever_it_stands(weak, strong):
    rows = ((SIDES[weak], Side()), (SIDES[strong], Side()))
    assert table(*rows).of(ANVIL, BENCH) == 1 and table(*rows[::-1]).of(ANVIL, BENCH) == 0


def test_the_more_specific_side_decides_before_the_other():
    rows = (
        (Side(material="Steel"), Side(material="Wood")),
        (Side(object="Anvil"), Side()),
        (Side(material="Steel"), Side()),
    )
    assert table(*rows).of(ANVIL, BENCH) == 1
    assert table(*rows).of(HAMMER, BENCH) == 0
    assert table(*rows).of(HAMMER, ANVIL) == 1
    assert table(*rows).of(HAMMER, ("Floor", "Stone")) == 2


def test_sides_fit_in_either_order_and_both_must():
    rows = table((Side(object="Hammer*"), Side(material="Wood")))
    assert rows.of(HAMMER, BENCH) == rows.of(BENCH, HAMMER) == 0
    assert rows.of(HAMMER, ANVIL) is None and rows.of(BENCH, BENCH) is None


def test_a_row_for_one_side_needs_only_one_of_the_two():
    rows = table((Side(material="Steel"), Side()))
    assert rows.of(ANVIL, BENCH) == rows.of(BENCH, ANVIL) == rows.of(ANVIL, HAMMER) == 0
    assert rows.of(BENCH, BENCH) is None


def test_of_equally_specific_rows_the_upper_one_counts():
    first, second = (Side(object="Anvil"), Side()), (Side(object="Hammer.001"), Side())
    assert table(first, second).of(HAMMER, ANVIL) == table(second, first).of(HAMMER, ANVIL) == 0


def test_only_stars_and_question_marks_are_wildcards():
    assert table((Side(object="Bench [old]"), Side())).of(BENCH, ANVIL) == 0
    assert table((Side(object="Bench [o-p]ld]"), Side())).of(("Bench old]", ""), ANVIL) is None
    assert table((Side(object="* [old]"), Side())).of(BENCH, ANVIL) == 0
    assert table((Side(object="bench*"), Side())).of(BENCH, ANVIL) is None


def test_what_has_no_material_fits_no_pattern_of_materials():
    rows = table((Side(material="*"), Side()))
    assert rows.of(("a", ""), ("b", "")) is None
    assert rows.of(("a", ""), ("b", "Wood")) == 0


def test_an_empty_table_says_nothing():
    assert table().of(ANVIL, BENCH) is None


def test_a_side_is_an_object_or_a_material():
    with pytest.raises(ValueError, match="material"):
        Side(object="Anvil", material="Steel")
