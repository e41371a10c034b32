"""The columns of a trajectory that follow from others: acceleration, time, jerk, slope."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    Floats = NDArray[np.float64]


def derived(line: Mapping[str, Floats], power: Floats, *, closed: bool) -> dict[str, Floats]:
    """The columns of `line` (s, v and z among them, (n,) each) with a, t, power, jerk and slope added, as `Trajectory` defines them.

    Args:
        line: the given columns; a fault in them is not noticed here but by the check of the finished table.
        power: (n - 1,) mean power of each interval or one, W.
        closed: the end joins the start.
    """
    s, v = line["s"], line["v"]
    with np.errstate(all="ignore"):
        a = np.diff(v**2) / (2.0 * np.diff(s))
        duration = 2.0 * np.diff(s) / (v[1:] + v[:-1])
        return {
            **line,
            "a": _held(a, closed),
            "t": np.concatenate([[0.0], np.cumsum(duration)]),
            "power": _held(np.broadcast_to(power, a.shape), closed),
            "jerk": _jerk(a, duration, closed),
            "slope": _slope(s, line["z"], closed),
        }


def _held(values: Floats, closed: bool) -> Floats:
    """(n,) from the values of n - 1 intervals: each at the station where its interval begins."""
    return np.append(values, values[0] if closed else values[-1])


def _jerk(a: Floats, duration: Floats, closed: bool) -> Floats:
    if len(a) < 2 and not closed:
        return np.zeros(len(a) + 1)
    change = np.diff(a) / (0.5 * (duration[1:] + duration[:-1]))
    if closed:
        seam = (a[0] - a[-1]) / (0.5 * (duration[0] + duration[-1]))
        return np.concatenate([[seam], change, [seam]])
    return np.concatenate([change[:1], change, change[-1:]])


def _slope(s: Floats, z: Floats, closed: bool) -> Floats:
    """Differences good to the second power of the step."""
    if not closed:
        return np.gradient(z, s, edge_order=1 if len(s) < 3 else 2)
    before, after = s[0] - (s[-1] - s[-2]), s[-1] + (s[1] - s[0])
    return np.gradient(np.concatenate([[z[-2]], z, [z[1]]]), np.concatenate([[before], s, [after]]))[1:-1]
