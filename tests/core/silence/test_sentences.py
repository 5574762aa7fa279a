"""Sentences of messages: every cause has one, with exactly the arguments that the core gives, and
numbers have their units."""

import re

import pytest
from haptic_tracing.core.message import (
    Cause,
    Chain,
    Decibels,
    Hertz,
    Message,
    Metres,
    Names,
    Seconds,
    sentence,
    written,
)


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (Metres(0.0042), "4.2 mm"),
        (Metres(0.032), "3.2 cm"),
        (Metres(0.3), "30.0 cm"),
        (Metres(2.5), "2.5 m"),
        (Decibels(-58.4), "−58 dB"),
        (Decibels(-0.2), "0 dB"),
        (Decibels(78.2), "78 dB"),
        (Hertz(39.6), "40 Hz"),
        (Seconds(0.1), "0.10 s"),
        (Seconds(0.05), "50 ms"),
        (Chain(("ground", "bench", "seat")), "ground > bench > seat"),
        (Chain("abcdefgh"), "a > b > c > ... > g > h"),
        (Names(("hand.L", "foot.R")), "hand.L, foot.R"),
        (3, "3"),
    ],
)
def test_arguments_are_written_with_their_unit(value, text):
    assert written(value) == text


def test_a_sentence_fills_names_that_look_like_gaps():
    message = Message.of(Cause.MUTED, source="a {b} 'c'")
    assert sentence(message) == "'a {b} 'c'' is muted"
    assert sentence(message, "„{source}“ ist stumm") == "„a {b} 'c'“ ist stumm"


def test_no_sentence_ends_with_a_full_stop_or_has_unnamed_gaps():
    for words in (cause.value for cause in Cause):
        assert words
        assert not words.endswith(".")
        assert all(re.findall(r"\{(\w*)\}", words)), words
