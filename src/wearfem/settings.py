"""Settings from the command line: `--set "throughput=900*tonne/hour"` becomes `{"throughput": 250.0}`.

A value is arithmetic on numbers and the names of `wearfem.units`, `true` or `false`, a word, quoted text, or
a comma list of these. Nothing else is evaluated.
"""

import ast
import inspect
import math
import operator
import re
from collections.abc import Callable, Iterable, Mapping
from difflib import get_close_matches
from typing import Any, Literal, get_args, get_origin

from wearfem import units
from wearfem.errors import UserError, in_words

Value = float | int | bool | str | tuple[Any, ...]

UNITS: Mapping[str, float] = {name: value for name, value in vars(units).items() if isinstance(value, float)}
OPERATIONS: Mapping[type[ast.operator], Callable[[float, float], Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.Pow: lambda base, exponent: float(base) ** exponent,
}
WORD = re.compile(r"[A-Za-z_][\w.]*")


def parse_settings(texts: Iterable[str]) -> dict[str, Value]:
    """Values by keyword, in SI, from texts like `radius=4*mm`."""
    settings: dict[str, Value] = {}
    for text in texts:
        keyword, equals, expression = (part.strip() for part in text.partition("="))
        if not (equals and keyword.isidentifier() and expression):
            raise UserError(
                f'--set was given "{text}", but it needs KEYWORD=VALUE, like "throughput=900*tonne/hour"'
            )
        if keyword in settings:
            raise UserError(f"--set was given {keyword} twice: keep one of them")
        settings[keyword] = parse_value(keyword, expression)
    return settings


def parse_value(keyword: str, text: str) -> Value:
    """The value of one expression, in SI; `keyword` is only told in errors."""
    try:
        tree = ast.parse(text, mode="eval").body
        value = _evaluate(tree)
    except UserError as error:
        raise UserError(f'--set {keyword}="{text}": {error}') from None
    except ZeroDivisionError:
        raise UserError(f'--set {keyword}="{text}" divides by zero: correct the expression') from None
    except OverflowError:
        raise UserError(
            f'--set {keyword}="{text}" is too large for a number: correct the expression'
        ) from None
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        raise UserError(
            f'--set {keyword}="{text}" cannot be read: expected numbers, units and + - * / ** ( ), as in '
            "4*mm, a word, or a text in quotes"
        ) from None
    return value


def _evaluate(node: ast.expr) -> Value:
    if isinstance(node, ast.Tuple):
        return tuple(_evaluate(element) for element in node.elts)
    if isinstance(node, ast.Constant) and isinstance(node.value, str | bool):
        return node.value
    word = ast.unparse(node)
    if isinstance(node, ast.Name | ast.Attribute) and word not in UNITS and WORD.fullmatch(word):
        return {"true": True, "false": False}.get(word.lower(), word)
    return _number(node)


def _number(node: ast.expr) -> float | int:
    """The value of pure arithmetic."""
    value: Any
    match node:
        case ast.Constant(value=int() | float()) if not isinstance(node.value, bool):
            value = node.value
        case ast.Name(id=name):
            if name not in UNITS:
                raise UserError(
                    f"{name} is not a unit{did_you_mean(name, UNITS)}; the units are {in_words(list(UNITS))}"
                )
            value = UNITS[name]
        case ast.UnaryOp(op=ast.USub(), operand=operand):
            value = -_number(operand)
        case ast.UnaryOp(op=ast.UAdd(), operand=operand):
            value = _number(operand)
        case ast.BinOp(left=left, op=symbol, right=right) if type(symbol) in OPERATIONS:
            value = OPERATIONS[type(symbol)](_number(left), _number(right))
        case _:
            raise UserError(
                f"{ast.unparse(node)} is not allowed here: use numbers, units and + - * / ** ( ), "
                "or put a text in quotes"
            )
    if isinstance(value, complex) or not math.isfinite(value):
        raise UserError(f"{ast.unparse(node)} is not a finite real number")
    return value


def did_you_mean(name: str, names: Iterable[str]) -> str:
    """` (did you mean a or b?)` for the nearest names, or nothing when none is near."""
    lower = {candidate.lower(): candidate for candidate in names}
    near = [lower[match] for match in get_close_matches(name.lower(), lower, n=3, cutoff=0.6)]
    return f" (did you mean {' or '.join(near)}?)" if near else ""


def check_settings(
    settings: Mapping[str, Value], signature: inspect.Signature, case_name: str
) -> dict[str, Any]:
    """All keywords of the case: the value from `settings`, checked against the default, or the default."""
    parameters = signature.parameters
    for keyword in settings:
        if keyword not in parameters:
            raise UserError(
                f"{case_name} has no keyword {keyword}{did_you_mean(keyword, parameters)}; "
                f"its keywords are, in SI, {keyword_list(signature)}"
            )
    resolved = {name: parameter.default for name, parameter in parameters.items()}
    for keyword, value in settings.items():
        resolved[keyword] = _like_default(keyword, value, parameters[keyword])
    return resolved


def keyword_list(signature: inspect.Signature) -> str:
    """`force=5, resolution=full`: the keywords of a case with their defaults as they would be typed, in SI, or `none`."""
    defaults = [f"{name}={_typed(parameter.default)}" for name, parameter in signature.parameters.items()]
    return ", ".join(defaults) or "none"


def _typed(value: Value) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    return f"{value:g}" if isinstance(value, float) else str(value)


def _like_default(keyword: str, value: Value, parameter: inspect.Parameter) -> Any:
    """The value as the kind of thing that the keyword's default is."""
    default, annotation = parameter.default, parameter.annotation
    choices = get_args(annotation) if get_origin(annotation) is Literal else ()
    if choices and value not in choices:
        allowed = in_words([str(choice) for choice in choices], "or")
        raise UserError(f"{keyword} was given {value!r}, but it can be {allowed}")
    if isinstance(default, bool):
        return _expect(isinstance(value, bool), keyword, value, "true or false", default)
    if isinstance(default, str):
        return _expect(isinstance(value, str), keyword, value, "a word or a text in quotes", default)
    if isinstance(default, tuple):
        return value if isinstance(value, tuple) else (value,)
    if isinstance(default, int | float):
        number = isinstance(value, int | float) and not isinstance(value, bool)
        hint = did_you_mean(value, UNITS) if isinstance(value, str) else ""
        _expect(number, keyword, value, f"a number in SI, or with a unit as in 4*mm{hint}", default)
        if isinstance(default, float):
            return float(value)  # type: ignore[arg-type]
        return int(_expect(value == int(value), keyword, value, "a whole number", default))  # type: ignore[arg-type]
    return value


def _expect(right: bool, keyword: str, value: Value, expected: str, default: Any) -> Value:
    if not right:
        raise UserError(f"{keyword} was given {value!r}, but it needs {expected}; its default is {default!r}")
    return value
