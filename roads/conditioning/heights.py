"""Heights along the way: what no road can be is left out, the rest smoothed as far as it is noise."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from .spline import Smoother, cross_validated, noise_of, within

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]
    Bools = NDArray[np.bool_]

#: Steeper is no public road; a building, a bridge that the height data do not know, or a loss of the signal.
STEEPEST = 0.30
#: Over heights that are left out, no road is taken to be steeper: else a tower would become a hill by leaving out its walls.
STEEPEST_UNSEEN = 0.15
#: A stretch that cannot be reached is given up if it is shorter than this, m; a longer one is kept, with a step at its ends.
LONGEST_WRONG = 500.0
#: Heights that are off by less are left as they are, m.
QUIET = 0.05
#: Heights within this way are looked at together, m.
_BIN = 10.0
#: Steps in which heights are told, m.
_STEPS = (10.0, 5.0, 2.0, 1.0, 0.5, 0.25, 0.2, 0.1)
#: Fewer different heights tell no step.
_FEW = 5


@dataclass(frozen=True, eq=False)
class Heights:
    """Heights of a road.

    Attributes:
        height: (m,) at the stations asked for, m.
        wrong: (n,) which of the recorded ones were left out.
        noise: root mean square of what the others were moved by, m.
        step: in which they were told, m; 0 where it is fine.
    """

    height: Floats
    wrong: Bools
    noise: float
    step: float


def smoothed_heights(s: Floats, z: Floats, at: Floats, accuracy: float | None) -> Heights:
    """Heights at stations `at` (m,), m, from those recorded.

    Args:
        s: (n,) stations of the recorded heights, m, in any order.
        z: (n,) heights, m.
        at: wanted stations, m.
        accuracy: root mean square by which they may be off, m; None: the smoothness that foretells them best, at least what their steps call for.
    """
    order = np.argsort(s, kind="stable")
    s, z = s[order], z[order]
    wrong = implausible(s, z)
    kept_s, kept_z = s[~wrong], z[~wrong]
    step = told_in(z)
    quiet = accuracy is None and step == 0.0 and not wrong.any() and noise_of(kept_z) < QUIET
    if quiet or len(kept_s) < 6 or float(np.ptp(kept_z)) == 0.0:
        height, noise = np.interp(at, *_single(kept_s, kept_z)), 0.0
    else:
        height, noise = _fitted(kept_s, kept_z, at, accuracy, step)
    back = np.zeros(len(s), dtype=bool)
    back[order] = wrong
    return Heights(height, back, noise, step)


def _single(s: Floats, z: Floats) -> tuple[Floats, Floats]:
    """One height at each place: the mean where a car stood."""
    places, which = np.unique(s, return_inverse=True)
    return places, np.bincount(which, z) / np.bincount(which)


def _fitted(s: Floats, z: Floats, at: Floats, accuracy: float | None, step: float) -> tuple[Floats, float]:
    length = max(float(s[-1] - s[0]), 1e-6)
    spacing = float(np.clip(length / len(s), 5.0, 50.0))
    cell = np.floor((s - s[0]) / spacing).astype(np.intp)
    count = np.bincount(cell)
    weight = np.minimum(1.0, float(np.median(count[count > 0])) / count[cell])
    smoother = Smoother(s, z[:, None], spacing, 2, weight)
    if accuracy is not None:
        fit = within(smoother, accuracy)
    else:
        fit = smoother.fit(cross_validated(s, z[:, None], spacing, 2, weight, lenient=True))
        if step > 0.0 and _moved(smoother, fit.coefficients, fit.weight) < step / np.sqrt(12.0):
            # stairs foretell themselves: what was rounded is off by this much
            fit = within(smoother, step / np.sqrt(12.0))
    return fit(np.clip(at, s[0], s[-1]))[:, 0], _moved(smoother, fit.coefficients, fit.weight)


def _moved(smoother: Smoother, coefficients: Floats, weight: Floats) -> float:
    return float(np.sqrt(np.average(smoother.residual(coefficients) ** 2, weights=weight + 1e-12)))


def told_in(z: Floats) -> float:
    """The coarse step, m, of which all heights are multiples; 0 where there is none, or too few different heights to tell."""
    if len(np.unique(z)) < _FEW:
        return 0.0
    return next((step for step in _STEPS if np.all(np.abs(z / step - np.round(z / step)) < 1e-6)), 0.0)


def implausible(s: Floats, z: Floats) -> Bools:
    """Which heights (n,) at increasing stations `s` (n,), m, no road could reach from the others.

    Kept is the chain of heights, each reachable from the one before on the steepest road, that covers most of the way (dynamic programming over
    medians of stretches). A chain may also jump, at the price of `LONGEST_WRONG` of its way.
    """
    if len(s) < 3 or float(np.ptp(z)) == 0.0:
        return np.zeros(len(s), dtype=bool)
    cell = np.unique(np.floor((s - s[0]) / _BIN).astype(np.intp), return_inverse=True)[1]
    count = np.bincount(cell)
    splits = np.split(np.arange(len(s)), np.cumsum(count)[:-1])
    middle = np.array([float(np.median(z[part])) for part in splits])
    place = np.bincount(cell, s) / count
    noise = max(noise_of(z), told_in(z) / np.sqrt(12.0))
    slack = 4.5 * noise / np.sqrt(float(np.median(count)))
    keep = _chain(place, middle, slack)
    return ~keep[cell]


def _chain(s: Floats, z: Floats, slack: float) -> Bools:
    share = np.gradient(s) if len(s) > 1 else np.ones(1)
    share = np.minimum(share, 5.0 * float(np.median(share)))
    value, before = share.copy(), np.full(len(s), -1)
    reach = int(np.ceil(LONGEST_WRONG / max(float(np.median(np.diff(s))), 1e-6))) + 1
    for k in range(1, len(s)):
        low = max(k - reach, 0)
        steepest = np.where(np.arange(low, k) == k - 1, STEEPEST, STEEPEST_UNSEEN)
        fits = np.abs(z[k] - z[low:k]) <= steepest * (s[k] - s[low:k]) + slack
        worth = value[low:k] - np.where(fits, 0.0, LONGEST_WRONG)
        best = int(np.argmax(worth))
        if worth[best] > 0.0:
            value[k] += worth[best]
            before[k] = low + best
    keep = np.zeros(len(s), dtype=bool)
    k = int(np.argmax(value))
    while k >= 0:
        keep[k] = True
        k = int(before[k])
    return keep
