"""Checks of user input: each returns a float or an array, or raises one clear error."""

from __future__ import annotations

import math
from collections.abc import Sequence
from numbers import Real

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rrrobot.errors import ParameterError, RRRobotError

Array = NDArray[np.float64]


def finite(
    name: str,
    value: object,
    unit: str = "",
    *,
    above: float | None = None,
    at_least: float | None = None,
    error: type[RRRobotError] = ParameterError,
) -> float:
    """Return `value` as a float; it must be a finite real number within the bound.

    Raises:
        ParameterError: (or `error`) with the name, the value, the unit and the rule.
    """
    rule = "finite"
    if above is not None:
        rule = f"greater than {_number(above)} and finite"
    elif at_least is not None:
        rule = f"at least {_number(at_least)} and finite"
    shown = f"{value!r} {unit}".rstrip()
    if isinstance(value, np.ndarray) and value.ndim != 0:
        raise error(f"{name} has shape {value.shape}: it must be one number, {rule}.")
    if isinstance(value, (np.generic, np.ndarray)):
        value = value.item()
    if isinstance(value, bool) or not isinstance(value, Real):
        raise error(f"{name} is {shown}: it must be a number, {rule}.")
    try:
        number = float(value)
    except OverflowError:
        raise error(f"{name} is too large: it must be {rule}.") from None
    shown = f"{number!r} {unit}".rstrip()
    out_of_bound = (above is not None and not number > above) or (
        at_least is not None and not number >= at_least
    )
    if not math.isfinite(number) or out_of_bound:
        raise error(f"{name} is {shown}: it must be {rule}.")
    return number


def whole(name: str, value: object, *, at_least: int, at_most: int | None = None) -> int:
    """Return `value` as an int; it must be a whole number in the range.

    Raises:
        ParameterError: with the name, the value and the rule.
    """
    rule = f"at least {at_least}" if at_most is None else f"from {at_least} to {at_most}"
    integer = isinstance(value, (int, np.integer)) and not isinstance(value, bool)
    if not integer or value < at_least or (at_most is not None and value > at_most):  # type: ignore[operator]
        raise ParameterError(f"{name} is {value!r}: it must be a whole number, {rule}.")
    return int(value)  # type: ignore[call-overload]


def vector(
    name: str,
    value: ArrayLike,
    size: int,
    unit: str = "",
    *,
    broadcast: bool = False,
    labels: Sequence[str] = (),
    error: type[RRRobotError] = ParameterError,
) -> Array:
    """Return `value` as a finite array of shape (size,); a scalar is repeated if `broadcast`.

    Raises:
        ParameterError: (or `error`) with the name, the shape or value, and what is allowed.
    """
    names = f" ({', '.join(labels)})" if labels else ""
    scalar = " or one number for all" if broadcast else ""
    rule = f"it must hold {size} number{'s' * (size != 1)}{names}{scalar}"
    try:
        given = np.asarray(value)
        if given.dtype.kind not in "iufO":
            raise TypeError("strings, booleans and complex numbers are no real numbers")
        array = np.array(given, dtype=float)
    except (TypeError, ValueError, OverflowError) as cause:
        raise error(f"{name} is {value!r}: {rule}.") from cause
    if broadcast and array.ndim == 0:
        array = np.full(size, float(array))
    if array.shape != (size,):
        raise error(f"{name} has shape {array.shape}: {rule}.")
    if not np.all(np.isfinite(array)):
        shown = f"{array.tolist()} {unit}".rstrip()
        raise error(f"{name} is {shown}: every entry must be finite.")
    return array


def _number(bound: float) -> str:
    return "zero" if bound == 0 else repr(bound)
