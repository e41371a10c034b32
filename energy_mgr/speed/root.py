"""Bracketed root finding. SciPy has better ones; importing `scipy.optimize` for this would take longer than planning the speed."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable


def root(function: Callable[[float], float], low: float, high: float, tolerance: float) -> float:
    """A root of the continuous `function` between `low` and `high`, where its signs differ, to `tolerance` in the argument or the value.

    Regula falsi with the Illinois weighting, and a bisection whenever three steps have not halved the bracket.

    Raises:
        ValueError: the signs at both ends are the same.
    """
    at_low, at_high = function(low), function(high)
    if at_low == 0.0 or at_high == 0.0:
        return low if at_low == 0.0 else high
    if (at_low > 0.0) == (at_high > 0.0):
        raise ValueError(f"no change of sign between {low:g} ({at_low:g}) and {high:g} ({at_high:g})")
    weight_low, weight_high, width, steps = at_low, at_high, high - low, 0
    while high - low > tolerance:
        middle = (low * weight_high - high * weight_low) / (weight_high - weight_low)
        if steps == 3:
            middle, width, steps = 0.5 * (low + high), high - low, 0
        value = function(middle)
        if abs(value) <= tolerance or not low < middle < high:
            return middle
        if (value > 0.0) == (at_low > 0.0):
            low, at_low, weight_low, weight_high = middle, value, value, 0.5 * weight_high
        else:
            high, at_high, weight_high, weight_low = middle, value, value, 0.5 * weight_low
        steps = 0 if high - low < 0.5 * width else steps + 1
        width = high - low if steps == 0 else width
    return 0.5 * (low + high)
