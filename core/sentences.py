"""English sentences of messages, and how their arguments are written in any language."""

from __future__ import annotations

from collections.abc import Mapping

from .message import Argument, Cause, Chain, Decibels, Hertz, Message, Metres, Names, Seconds

ENGLISH: Mapping[Cause, str] = {
    Cause.NO_SOURCE: "there is no source, and no collision was strong enough to make one",
    Cause.MUTED: "'{source}' is muted",
    Cause.ZERO_AMPLITUDE: "'{source}' has amplitude 0",
    Cause.FINISHED: "the signal of '{source}' ended at {end}",
    Cause.NEAREST_LISTENER_ONLY: "in mode SD only '{listener}', the listener nearest to '{source}', feels it",
    Cause.LOCALISED: "with Localise at 1 only '{listener}', the listener nearest to '{source}', feels it",
    Cause.LISTENER_GAIN: "the gain of '{listener}' is 0",
    Cause.NOT_RENDERED: "only this one frame was traced: play to feel what arrives",
    Cause.PAUSE: "'{source}' reaches it with a gain of {gain}, but is silent at this moment",
    Cause.NOT_FELT: "'{source}' reaches it with a gain of {gain}; at {frequency} that is {margin} under the threshold of feeling",
    Cause.NO_CONTACT: "no contact leads from '{source}' on '{carrier}' to '{object}', which '{listener}' is on",
    Cause.GAP: "no contact leads from '{source}' to it: '{first}' and '{second}' are {distance} apart",
    Cause.NARROW_GAP: "no contact leads from '{source}' to it: '{first}' and '{second}' are {distance} apart; "
    "objects touch below {tolerance}",
    Cause.SEVERAL_GAPS: "no contact leads from '{source}' to it: there are {count} gaps on the way, "
    "the widest of {distance} between '{first}' and '{second}'",
    Cause.BELOW_THRESHOLD: "the best path, {path}, has a gain of {gain}, below the threshold of {threshold}: "
    "'{object}' loses the most, {loss} over {distance}",
    Cause.TOO_FAR: "'{source}' is {distance} away: {gain} is below the threshold of {threshold}",
    Cause.TOO_LONG: "the path {path} has {count} connections, but Max Connections is {most}",
    Cause.NO_CONNECTION_ALLOWED: "Max Connections is 0: no path is allowed",
    Cause.KAPPA_ONE: "'{object}' transmits nothing, because its kappa is 1",
    Cause.RHO_ZERO: "'{object}' transmits nothing, because its rho is 0",
    Cause.FUNCTION_ZERO: "'{object}' transmits nothing over {distance}: change its function, {function}",
    Cause.CONTACT_ZERO: "the contact of '{first}' and '{second}' transmits nothing",
    Cause.NO_SIMPLE_PATH: "the path {path} would cross an object twice in a row",
    Cause.TRANSFORM_NOT_FINITE: "'{object}' is left out: its transform is not finite",
    Cause.AMPLIFICATION: "some gains are above 1: paths were searched by their number of connections; "
    "the energy balance counts such gains as 1",
    Cause.PATH_BUDGET: "the search ended at its limit before the best paths were certain: see the error bounds",
    Cause.SUM_SET_BY_THRESHOLD: "the sum over all paths from '{source}' is set by its threshold: what lies below adds up without bound "
    "(walk radius at least {radius}); the strategies Automatic and Energy Balance do not depend on it",
    Cause.SUM_SET_BY_CONNECTIONS: "the sum over all paths from '{source}' is set by Max Connections: longer paths add up without bound "
    "(walk radius at least {radius}); the strategies Automatic and Energy Balance do not depend on it",
    Cause.SUM_TRUNCATED: "the limits leave out more than the tolerance of a sum over all paths from '{source}': see the error bounds",
    Cause.SUM_DIVERGES: "a sum over paths grows without bound: its gain is a lower bound; the strategy Energy Balance suits such a scene",
    Cause.SUM_BUDGET: "the search ended at its limit before a sum over paths was certain: its gain is a lower bound, see the error bounds",
    Cause.GAIN_OVERFLOW: "a gain is too large for a number: it is given as 1e300, a lower bound",
    Cause.FORCE_UNKNOWN: "what presses '{first}' and '{second}' together can't be known: bodies need a mass, must rest on what carries "
    "them, and at most 150 may hang together; as many contacts pass as if pressed by the reference force: {count}",
    Cause.NO_ACTUATOR: "not felt: no device has an actuator at {body_part}",
    Cause.NO_BODY_PART: "not felt: no actuator is chosen, and the listener has no body part",
    Cause.ACTUATOR_GONE: "not felt through {actuators}: not connected",
    Cause.SHARED_ACTUATOR: "felt together with {listeners}: they share {actuator} of {device}",
    Cause.OUT_OF_BAND: "its signal ({low} to {high}) is outside what {actuator} of {device} can play ({lowest} to {highest})",
    Cause.PARTLY_OUT_OF_BAND: "its signal ({low} to {high}) is partly outside what {actuator} of {device} can play ({lowest} to {highest})",
    Cause.STRENGTH_ONLY: "{actuator} of {device} plays strength, not frequency",
    Cause.LATE: "{actuator} of {device} answers after {delay}; more than {limit} is noticed",
    Cause.FORMULA_NOT_TEXT: "expected text, got {type}",
    Cause.FORMULA_TOO_LONG: "longer than {most} characters",
    Cause.FORMULA_TOO_COMPLEX: "more than {most} parts",
    Cause.FORMULA_INCOMPLETE: "not a formula: something is missing at its end",
    Cause.FORMULA_SYNTAX: "not a formula: {parser}",
    Cause.FORMULA_INVALID: "not a formula",
    Cause.FORMULA_UNKNOWN_NAME: "unknown name '{name}'; known are {known}",
    Cause.FORMULA_CALL: "'{name}' can't be called like this; functions are {known}",
    Cause.FORMULA_ARGUMENTS: "wrong number of arguments of {name}(): {count} instead of {expected}",
    Cause.FORMULA_NOT_ALLOWED: "{part} is not allowed",
    Cause.FORMULA_NOT_A_NUMBER: "{value} is not a number",
    Cause.FORMULA_NUMBER_TOO_LARGE: "number too large",
    Cause.FORMULA_COMPARISON: "where() compares with <, <=, > or >=",
    Cause.FORMULA_DEGREE: "must be proportional to x, but grows with x to the power {degree}",
    Cause.FORMULA_X_IN_POWER: "x can't stand in a power: the formula must be proportional to x",
    Cause.FORMULA_X_IN_CONDITION: "a condition can't depend on x",
    Cause.FORMULA_X_IN_FUNCTION: "x can't stand inside {name}(): the formula must be proportional to x",
    Cause.FORMULA_MIXED_TERMS: "terms with and without x are mixed: the formula must be proportional to x",
    Cause.FORMULA_CONTACT_VARIABLE: "{name} is 0 inside an object: only a contact has one",
    Cause.FORMULA_NOT_FINITE: "no finite value at {distance} m; divided by zero?",
    Cause.FORMULA_NEGATIVE: "negative at {distance} m; a gain is 0 or more",
    Cause.FORMULA_AMPLIFIES: "amplifies: the gain is {gain} at {distance} m",
    Cause.MIX_NOT_FINITE: "no finite value where sum is {sum}: nothing is felt there",
    Cause.MIX_NOT_SILENT: "{value} where no source sounds; it should be 0",
}

_LONGEST_CHAIN = 6


def sentence(message: Message, template: str | None = None) -> str:
    """A message as a sentence without a full stop: in English, or by the ``template`` of another language."""
    return (template or ENGLISH[message.cause]).format_map({name: written(value) for name, value in message.arguments})


def written(value: Argument) -> str:
    """An argument as text: numbers with their unit, long paths without their middle."""
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
            return " > ".join(value if len(value) <= _LONGEST_CHAIN else (*value[:3], "...", *value[-2:]))
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
