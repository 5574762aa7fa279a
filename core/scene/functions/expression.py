"""Designers' expressions, compiled from a whitelist of operations, so that an untrusted file cannot
run code.

Grammar: numbers, the variables below, ``+ - * / **``, comparisons inside ``where(condition, a,
b)``, and the functions below. No attributes, no indexing, no other names, at most `MAX_LENGTH`
characters and `MAX_NODES` parts: evaluation is bounded and loop-free.
"""

from __future__ import annotations

import ast
import math
from collections.abc import Callable, Collection, Mapping
from typing import Any

import numpy as np

from ...arrays import FloatArray
from ...forms import Form, JsonObject
from ...frozen import frozen
from ...message import Argument, Cause, Message, Names, sentence

CONTACT_VARIABLES = ("area", "depth", "angle", "force")
"""Variables that are available only for contacts."""
VARIABLES = ("x", "d", "kappa", "rho", "epsilon", *CONTACT_VARIABLES)
"""Variables of a modulation function."""
MIXING_VARIABLES = ("sum", "weighted", "strongest", "power", "s_max")
"""Variables of a mixing formula: for each sample the results of the other mixing methods, not
limited, and the listener's ceiling."""
CONSTANTS = {"pi": math.pi, "e": math.e}
MAX_LENGTH = 500
MAX_NODES = 200


@frozen
class _Function:
    arguments: int
    array: Callable[..., Any]
    keeps_scale: bool = False  # f(c a, c b) = c f(a, b) for c >= 0


_FUNCTIONS: dict[str, _Function] = {
    "exp": _Function(1, np.exp),
    "log": _Function(1, np.log),
    "sqrt": _Function(1, np.sqrt),
    "tanh": _Function(1, np.tanh),
    "atan": _Function(1, np.arctan),
    "sin": _Function(1, np.sin),
    "cos": _Function(1, np.cos),
    "abs": _Function(1, np.abs, keeps_scale=True),
    "min": _Function(2, np.minimum, keeps_scale=True),
    "max": _Function(2, np.maximum, keeps_scale=True),
}
FUNCTION_NAMES = (*_FUNCTIONS, "where")

_BINARY: dict[type[ast.operator], Callable[..., Any]] = {
    ast.Add: np.add,
    ast.Sub: np.subtract,
    ast.Mult: np.multiply,
    ast.Div: np.true_divide,
    ast.Pow: np.power,
}
_COMPARE: dict[type[ast.cmpop], Callable[..., Any]] = {
    ast.Lt: np.less,
    ast.LtE: np.less_equal,
    ast.Gt: np.greater,
    ast.GtE: np.greater_equal,
}


class ExpressionError(ValueError):
    """Error for a rejected formula: the ``message`` and the 0-based ``column`` of the fault."""

    def __init__(self, message: Message, column: int = 0) -> None:
        super().__init__(f"expression: {sentence(message)} (column {column + 1})")
        self.message = message
        self.column = column

    @classmethod
    def of(cls, cause: Cause, column: int = 0, **arguments: Argument) -> ExpressionError:
        """An error of this ``cause``."""
        return cls(Message.of(cause, **arguments), column)


@frozen
class CompiledExpression:
    """A checked formula. Compared and hashed by its source."""

    source: str
    tree: ast.expr

    def evaluate(
        self, distance: FloatArray, values: Mapping[str, float | FloatArray]
    ) -> FloatArray:
        """The gain (the formula at x = 1) at each distance (metres). May contain NaN or infinity,
        which the caller must handle."""
        variables: JsonObject = {
            "x": 1.0,
            "d": np.asarray(distance, dtype=np.float64),
            **values,
            **CONSTANTS,
        }
        with np.errstate(all="ignore"):
            result = _evaluate(self.tree, variables)
        return np.array(np.broadcast_to(np.asarray(result, dtype=np.float64), np.shape(distance)))

    def uses(self, *variables: str) -> bool:
        """Whether the formula uses any of the ``variables``."""
        return any(
            isinstance(node, ast.Name) and node.id in variables for node in ast.walk(self.tree)
        )


def compile_expression(source: str, variables: Collection[str] = VARIABLES) -> CompiledExpression:
    """Check a formula against the whitelist, with these ``variables``.

    Raises ExpressionError, which gives the column, for anything that is not allowed, or if ``x`` is
    used but the formula is not proportional to it.
    """
    if not isinstance(source, str):
        raise ExpressionError.of(Cause.FORMULA_NOT_TEXT, type=type(source).__name__)
    if len(source) > MAX_LENGTH:
        raise ExpressionError.of(Cause.FORMULA_TOO_LONG, MAX_LENGTH, most=MAX_LENGTH)
    formula = source.strip()
    indent = len(source) - len(source.lstrip())
    try:
        tree = ast.parse(formula, mode="eval").body
    except SyntaxError as error:
        if not error.offset:  # the parser ran out of text
            raise ExpressionError.of(Cause.FORMULA_INCOMPLETE, indent + len(formula)) from None
        raise ExpressionError.of(
            Cause.FORMULA_SYNTAX, indent + error.offset - 1, parser=error.msg
        ) from None
    except (ValueError, MemoryError, RecursionError):
        raise ExpressionError.of(Cause.FORMULA_INVALID) from None
    if sum(1 for _ in ast.walk(tree)) > 3 * MAX_NODES:
        raise ExpressionError.of(Cause.FORMULA_TOO_COMPLEX, most=MAX_NODES)
    try:
        degree = _degree(tree, variables)
    except ExpressionError as error:  # the parser counts the bytes of UTF-8
        before = formula.encode()[: error.column].decode(errors="ignore")
        raise ExpressionError(error.message, indent + len(before)) from None
    if degree not in (0, 1, None):
        raise ExpressionError.of(Cause.FORMULA_DEGREE, degree=degree)
    return CompiledExpression(source, tree)


def _degree(node: ast.expr, variables: Collection[str]) -> int | None:
    """Check one node and return its degree in x: f(c x) = c^degree f(x) for c >= 0. None for a
    literal 0, which has any degree."""
    match node:
        case ast.Constant():
            return _degree_of_constant(node)
        case ast.Name(id=name):
            if name not in variables and name not in CONSTANTS:
                known = Names((*variables, *CONSTANTS, *FUNCTION_NAMES))
                raise ExpressionError.of(
                    Cause.FORMULA_UNKNOWN_NAME, node.col_offset, name=name, known=known
                )
            return 1 if name == "x" else 0
        case ast.UnaryOp(op=ast.USub() | ast.UAdd(), operand=operand):
            return _degree(operand, variables)
        case ast.BinOp(op=ast.Add() | ast.Sub(), left=left, right=right):
            return _same_degree(node, [left, right], variables)
        case ast.BinOp(op=ast.Mult(), left=left, right=right):
            degrees = _degree(left, variables), _degree(right, variables)
            return None if None in degrees else degrees[0] + degrees[1]  # type: ignore[operator]
        case ast.BinOp(op=ast.Div(), left=left, right=right):
            top = _degree(left, variables)
            bottom = _degree(right, variables)
            return None if top is None else top - (bottom or 0)
        case ast.BinOp(op=ast.Pow(), left=left, right=right):
            if _degree(left, variables) or _degree(right, variables):
                raise ExpressionError.of(Cause.FORMULA_X_IN_POWER, node.col_offset)
            return 0
        case ast.Call(
            func=ast.Name(id="where"),
            args=[ast.Compare(left=left, ops=[operator], comparators=[right]), a, b],
            keywords=[],
        ):
            if type(operator) not in _COMPARE:
                raise ExpressionError.of(Cause.FORMULA_COMPARISON, node.col_offset)
            if _degree(left, variables) or _degree(right, variables):
                raise ExpressionError.of(Cause.FORMULA_X_IN_CONDITION, node.col_offset)
            return _same_degree(node, [a, b], variables)
        case ast.Call(func=ast.Name(id=name), args=arguments, keywords=[]) if name in _FUNCTIONS:
            return _degree_of_call(node, name, arguments, variables)
        case ast.Call(func=ast.Name(id=name)):
            raise ExpressionError.of(
                Cause.FORMULA_CALL, node.col_offset, name=name, known=Names(FUNCTION_NAMES)
            )
        case _:
            raise ExpressionError.of(
                Cause.FORMULA_NOT_ALLOWED, getattr(node, "col_offset", 0), part=type(node).__name__
            )


def _degree_of_constant(node: ast.Constant) -> int | None:
    if isinstance(node.value, bool) or not isinstance(node.value, int | float):
        raise ExpressionError.of(
            Cause.FORMULA_NOT_A_NUMBER, node.col_offset, value=repr(node.value)
        )
    try:
        finite = math.isfinite(float(node.value))
    except OverflowError:
        finite = False
    if not finite:
        raise ExpressionError.of(Cause.FORMULA_NUMBER_TOO_LARGE, node.col_offset)
    return None if node.value == 0 else 0


def _degree_of_call(
    node: ast.expr, name: str, arguments: list[ast.expr], variables: Collection[str]
) -> int | None:
    function = _FUNCTIONS[name]
    if len(arguments) != function.arguments:
        raise ExpressionError.of(
            Cause.FORMULA_ARGUMENTS,
            node.col_offset,
            name=name,
            expected=function.arguments,
            count=len(arguments),
        )
    if function.keeps_scale:
        return _same_degree(node, arguments, variables)
    if any(_degree(argument, variables) for argument in arguments):
        raise ExpressionError.of(Cause.FORMULA_X_IN_FUNCTION, node.col_offset, name=name)
    return 0


def _same_degree(node: ast.expr, parts: list[ast.expr], variables: Collection[str]) -> int | None:
    degrees = {degree for part in parts if (degree := _degree(part, variables)) is not None}
    if len(degrees) > 1:
        raise ExpressionError.of(Cause.FORMULA_MIXED_TERMS, node.col_offset)
    return degrees.pop() if degrees else None


def _evaluate(node: ast.expr, variables: Form) -> Any:
    match node:
        case ast.Constant(value=value):
            return np.float64(value)  # type: ignore[arg-type]
        case ast.Name(id=name):
            return variables[name]
        case ast.UnaryOp(op=operator, operand=operand):
            value = _evaluate(operand, variables)
            return np.negative(value) if isinstance(operator, ast.USub) else value
        case ast.BinOp(op=operator, left=left, right=right):
            return _BINARY[type(operator)](_evaluate(left, variables), _evaluate(right, variables))
        case ast.Call(
            func=ast.Name(id="where"),
            args=[ast.Compare(left=left, ops=[operator], comparators=[right]), a, b],
        ):
            condition = _COMPARE[type(operator)](
                _evaluate(left, variables), _evaluate(right, variables)
            )
            return np.where(condition, _evaluate(a, variables), _evaluate(b, variables))
        case ast.Call(func=ast.Name(id=name), args=arguments):
            return _FUNCTIONS[name].array(
                *(_evaluate(argument, variables) for argument in arguments)
            )
    raise AssertionError("unreachable: the tree was checked")
