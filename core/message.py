"""Messages as data, a cause and its arguments, and as sentences."""

from __future__ import annotations

import enum

from .frozen import frozen


@enum.unique
class Cause(enum.Enum):
    """Kinds of messages: reasons for silence, warnings of a traced frame, losses between listeners
    and actuators, faults of formulas.

    The value is the English sentence with placeholders for the arguments; other languages have a
    table by the causes' names.
    """

    # What keeps a source from a listener: the source, the mode, what arrives
    NO_SOURCE = "there is no source, and no collision was strong enough to make one"
    MUTED = "'{source}' is muted"
    ZERO_AMPLITUDE = "'{source}' has amplitude 0"
    WAITING = "'{source}' waits for a trigger"
    FINISHED = "the signal of '{source}' ended at {end}"
    NEAREST_LISTENER_ONLY = (
        "in mode SD only '{listener}', the listener nearest to '{source}', feels it"
    )
    LISTENER_GAIN = "the gain of '{listener}' is 0"
    NOT_RENDERED = "only this one frame was traced: play to feel what arrives"
    PAUSE = "'{source}' reaches it with a gain of {gain}, but is silent at this moment"
    NOT_FELT = (
        "'{source}' reaches it with a gain of {gain}; the level of {level} is {margin} "
        "under the threshold of feeling at {frequency}"
    )
    # Gaps between objects
    NO_CONTACT = (
        "no contact leads from '{source}' on '{carrier}' to '{object}', which '{listener}' is on"
    )
    GAP = "no contact leads from '{source}' to it: '{first}' and '{second}' are {distance} apart"
    NARROW_GAP = (
        "no contact leads from '{source}' to it: '{first}' and '{second}' are "
        "{distance} apart; objects touch below {tolerance}"
    )
    SEVERAL_GAPS = (
        "no contact leads from '{source}' to it: there are {count} gaps on the way, "
        "the widest of {distance} between '{first}' and '{second}'"
    )
    # Losses on the path
    BELOW_THRESHOLD = (
        "the best path, {path}, has a gain of {gain}, below the threshold of "
        "{threshold}: '{object}' loses the most, {loss} over {distance}"
    )
    TOO_FAR = "'{source}' is {distance} away: {gain} is below the threshold of {threshold}"
    TOO_LONG = "the path {path} has {count} connections, more than the {most} of a sum over paths"
    KAPPA_ONE = "'{object}' transmits nothing, because its kappa is 1"
    RHO_ZERO = "'{object}' transmits nothing, because its rho is 0"
    FUNCTION_ZERO = "'{object}' transmits nothing over {distance}: change its function, {function}"
    CONTACT_ZERO = "the contact of '{first}' and '{second}' transmits nothing"
    NO_SIMPLE_PATH = "the path {path} would cross an object twice in a row"
    # Warnings of a frame
    TRANSFORM_NOT_FINITE = "'{object}' is left out: its transform is not finite"
    IMPACT_TIME = (
        "when '{first}' and '{second}' hit each other is uncertain by up to a frame: a simpler "
        "collision shape than Mesh, or more frames a second, makes it certain"
    )
    SUM_BUDGET = (
        "the search for paths from '{source}' ended at its limit of operations: the sum is a "
        "lower bound"
    )
    FORCE_UNKNOWN = (
        "the force between '{first}' and '{second}' is unknown: bodies need a mass and must rest "
        "on their supports, "
        "and at most 150 may be connected; contacts that count as under the reference force: "
        "{count}"
    )
    # Losses between listeners and actuators
    NO_ACTUATOR = "not felt: no device has an actuator at {body_part}"
    NO_BODY_PART = "not felt: no actuator is chosen, and the listener has no body part"
    ACTUATOR_GONE = "not felt through {actuators}: not connected"
    SHARED_ACTUATOR = "felt together with {listeners}: they share {actuator} of {device}"
    OUT_OF_BAND = (
        "its signal ({low} to {high}) is outside what {actuator} of {device} can play "
        "({lowest} to {highest})"
    )
    PARTLY_OUT_OF_BAND = (
        "its signal ({low} to {high}) is partly outside what {actuator} of "
        "{device} can play ({lowest} to {highest})"
    )
    STRENGTH_ONLY = "{actuator} of {device} plays strength, not frequency"
    LATE = "{actuator} of {device} answers after {delay}; more than {limit} is noticed"
    # Formulas that are not accepted
    FORMULA_NOT_TEXT = "expected text, got {type}"
    FORMULA_TOO_LONG = "longer than {most} characters"
    FORMULA_TOO_COMPLEX = "more than {most} parts"
    FORMULA_INCOMPLETE = "not a formula: something is missing at its end"
    FORMULA_SYNTAX = "not a formula: {parser}"
    FORMULA_INVALID = "not a formula"
    FORMULA_UNKNOWN_NAME = "unknown name '{name}'; known are {known}"
    FORMULA_CALL = "'{name}' can't be called like this; functions are {known}"
    FORMULA_ARGUMENTS = "wrong number of arguments of {name}(): {count} instead of {expected}"
    FORMULA_NOT_ALLOWED = "{part} is not allowed"
    FORMULA_NOT_A_NUMBER = "{value} is not a number"
    FORMULA_NUMBER_TOO_LARGE = "number too large"
    FORMULA_COMPARISON = "where() compares with <, <=, > or >="
    FORMULA_DEGREE = "must be proportional to x, but grows with x to the power {degree}"
    FORMULA_X_IN_POWER = "x can't stand in a power: the formula must be proportional to x"
    FORMULA_X_IN_CONDITION = "a condition can't depend on x"
    FORMULA_X_IN_FUNCTION = "x can't stand inside {name}(): the formula must be proportional to x"
    FORMULA_MIXED_TERMS = (
        "terms with and without x are mixed: the formula must be proportional to x"
    )
    # What a formula does
    FORMULA_CONTACT_VARIABLE = "{name} is 0 inside an object: only a contact has one"
    FORMULA_NOT_FINITE = "no finite value at {distance} m (κ {kappa}, ρ {rho}); divided by zero?"
    FORMULA_NEGATIVE = "negative at {distance} m (κ {kappa}, ρ {rho}); a gain is 0 or more"
    FORMULA_AMPLIFIES = "{gain} at {distance} m (κ {kappa}, ρ {rho}); a gain is at most 1"
    FORMULA_RISES = (
        "rises to {gain} at {distance} m (κ {kappa}, ρ {rho}); a gain falls with distance"
    )
    MIX_NOT_FINITE = "no finite value where sum is {sum}: nothing is felt there"
    MIX_NOT_SILENT = "{value} where no source sounds; it should be 0"


class Metres(float):
    """A length."""


class Decibels(float):
    """A gain, a level or a loss."""


class Hertz(float):
    """A frequency."""


class Seconds(float):
    """A time or a duration."""


class Chain(tuple[str, ...]):
    """Names of objects along a path."""


class Names(tuple[str, ...]):
    """Names in a list."""


Argument = str | int | Metres | Decibels | Hertz | Seconds | Chain | Names


@frozen
class Message:
    """A cause with its arguments by name. ``object``: the Blender or scene object to look at, ""
    for none."""

    cause: Cause
    arguments: tuple[tuple[str, Argument], ...] = ()
    object: str = ""

    @classmethod
    def of(cls, cause: Cause, about: str = "", /, **arguments: Argument) -> Message:
        """A message about the object ``about``."""
        return cls(cause, tuple(arguments.items()), about)

    def __getitem__(self, name: str) -> Argument:
        """The argument ``name``. Raises KeyError if there is none."""
        return dict(self.arguments)[name]


_LONGEST_CHAIN = 6


def sentence(message: Message, template: str | None = None) -> str:
    """A message as a sentence without a full stop: in English, or by the ``template`` of another
    language."""
    return (template or message.cause.value).format_map(
        {name: written(value) for name, value in message.arguments}
    )


def written(value: Argument) -> str:
    """An argument as text: numbers with their unit, long paths shortened in the middle."""
    match value:
        case Metres():
            return _length(value)
        case Decibels():
            return decibels(value)
        case Hertz():
            return f"{value:.0f} Hz"
        case Seconds():
            return f"{1000 * value:.0f} ms" if abs(value) < 0.1 else f"{value:.2f} s"
        case Chain():
            return " > ".join(
                value if len(value) <= _LONGEST_CHAIN else (*value[:3], "...", *value[-2:])
            )
        case Names():
            return ", ".join(value)
    return str(value)


def decibels(value: float) -> str:
    """Whole decibels with a real minus sign: "−12 dB"."""
    return f"\N{MINUS SIGN}{-value:.0f} dB" if round(value) < 0 else f"{abs(value):.0f} dB"


def _length(metres: float) -> str:
    if metres < 0.01:
        return f"{1000 * metres:.1f} mm"
    return f"{100 * metres:.1f} cm" if metres < 1 else f"{metres:.1f} m"
