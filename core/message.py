"""Messages to people as data: a cause and its arguments. `core.sentences` has the English table; other languages have their own."""

from __future__ import annotations

import enum
from dataclasses import dataclass


class Cause(enum.StrEnum):
    """Kinds of messages: reasons for silence, warnings of a traced frame, losses between listeners and actuators, faults of formulas."""

    # What keeps a source from a listener: the source, the mode, what arrives
    NO_SOURCE = enum.auto()
    MUTED = enum.auto()
    ZERO_AMPLITUDE = enum.auto()
    FINISHED = enum.auto()
    NEAREST_LISTENER_ONLY = enum.auto()
    LOCALISED = enum.auto()
    LISTENER_GAIN = enum.auto()
    NOT_RENDERED = enum.auto()
    PAUSE = enum.auto()
    NOT_FELT = enum.auto()
    # Gaps between objects
    NO_CONTACT = enum.auto()
    GAP = enum.auto()
    NARROW_GAP = enum.auto()
    SEVERAL_GAPS = enum.auto()
    # Losses on the path
    BELOW_THRESHOLD = enum.auto()
    TOO_FAR = enum.auto()
    TOO_LONG = enum.auto()
    NO_CONNECTION_ALLOWED = enum.auto()
    KAPPA_ONE = enum.auto()
    RHO_ZERO = enum.auto()
    FUNCTION_ZERO = enum.auto()
    CONTACT_ZERO = enum.auto()
    NO_SIMPLE_PATH = enum.auto()
    # Warnings of a frame
    TRANSFORM_NOT_FINITE = enum.auto()
    AMPLIFICATION = enum.auto()
    PATH_BUDGET = enum.auto()
    SUM_SET_BY_THRESHOLD = enum.auto()
    SUM_SET_BY_CONNECTIONS = enum.auto()
    SUM_TRUNCATED = enum.auto()
    SUM_DIVERGES = enum.auto()
    SUM_BUDGET = enum.auto()
    GAIN_OVERFLOW = enum.auto()
    FORCE_UNKNOWN = enum.auto()
    # Losses between listeners and actuators
    NO_ACTUATOR = enum.auto()
    NO_BODY_PART = enum.auto()
    ACTUATOR_GONE = enum.auto()
    SHARED_ACTUATOR = enum.auto()
    OUT_OF_BAND = enum.auto()
    PARTLY_OUT_OF_BAND = enum.auto()
    STRENGTH_ONLY = enum.auto()
    LATE = enum.auto()
    # Formulas that are not accepted
    FORMULA_NOT_TEXT = enum.auto()
    FORMULA_TOO_LONG = enum.auto()
    FORMULA_TOO_COMPLEX = enum.auto()
    FORMULA_INCOMPLETE = enum.auto()
    FORMULA_SYNTAX = enum.auto()
    FORMULA_INVALID = enum.auto()
    FORMULA_UNKNOWN_NAME = enum.auto()
    FORMULA_CALL = enum.auto()
    FORMULA_ARGUMENTS = enum.auto()
    FORMULA_NOT_ALLOWED = enum.auto()
    FORMULA_NOT_A_NUMBER = enum.auto()
    FORMULA_NUMBER_TOO_LARGE = enum.auto()
    FORMULA_COMPARISON = enum.auto()
    FORMULA_DEGREE = enum.auto()
    FORMULA_X_IN_POWER = enum.auto()
    FORMULA_X_IN_CONDITION = enum.auto()
    FORMULA_X_IN_FUNCTION = enum.auto()
    FORMULA_MIXED_TERMS = enum.auto()
    # What a formula does
    FORMULA_CONTACT_VARIABLE = enum.auto()
    FORMULA_NOT_FINITE = enum.auto()
    FORMULA_NEGATIVE = enum.auto()
    FORMULA_AMPLIFIES = enum.auto()
    MIX_NOT_FINITE = enum.auto()
    MIX_NOT_SILENT = enum.auto()


class Metres(float):
    """A length."""


class Decibels(float):
    """A level or a loss."""


class Hertz(float):
    """A frequency."""


class Seconds(float):
    """A time or a duration."""


class Chain(tuple[str, ...]):
    """Names of objects along a path."""


class Names(tuple[str, ...]):
    """Names in a list."""


Argument = str | int | Metres | Decibels | Hertz | Seconds | Chain | Names


@dataclass(frozen=True, slots=True)
class Message:
    """A cause with its arguments by name. ``object``: the Blender or scene object to look at, "" for none."""

    cause: Cause
    arguments: tuple[tuple[str, Argument], ...] = ()
    object: str = ""

    @classmethod
    def of(cls, cause: Cause, about: str = "", /, **arguments: Argument) -> Message:
        """A message about the object ``about``."""
        return cls(cause, tuple(arguments.items()), about)

    def __getitem__(self, name: str) -> Argument:
        """The argument ``name``; raises KeyError where there is none."""
        return dict(self.arguments)[name]
