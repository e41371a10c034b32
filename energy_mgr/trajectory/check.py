"""What a table must fulfil to be a trajectory: the first fault, in words, with its row."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping

    from numpy.typing import NDArray

    Floats = NDArray[np.float64]
    Found = tuple[NDArray[np.bool_], str, Floats, str]

#: Columns of files by the names of the attributes.
LABELS = {
    "s": "s_m", "x": "x_m", "y": "y_m", "z": "z_m", "psi": "psi_rad", "kappa": "kappa_1pm", "v": "v_mps", "a": "a_mps2", "t": "t_s",
    "power": "power_w", "jerk": "jerk_mps3", "slope": "slope", "bank": "bank_rad",
}  # fmt: skip
#: What follows from other columns.
_FOLLOWING = ("a", "t", "jerk", "slope")
#: No value on Earth is larger, in SI units; the readers of roads refuse what is.
LARGEST = 1e9
#: Points closer than this are one for the readers of roads, m.
CLOSEST = 1e-6
#: The ends of a closed track may lie this far apart, in m, rad, m/s and 1/m: what files round to.
SEAM = 1e-3
#: Columns that follow from others may be off by this share, and by this much: what files round to.
_SHARE, _ROUNDING = 1e-3, 1e-3
#: Heading and points, heading and curvature may differ by this over one interval, rad; degrees or headings from north differ by more.
_TURN = 0.5


class Fault(NamedTuple):
    """The row, counted from 0, and what is wrong there."""

    row: int
    text: str


def first_fault(columns: Mapping[str, Floats], *, closed: bool) -> Fault | None:
    """The first reason, if there is one, why columns (n,) of equal length, 2 or more, are no trajectory at all."""
    # one after the other: the later rules hold only for numbers, and what follows from others is not to blame before them
    return next(_faults(_given(columns)), None) or next(_faults(_derived(columns)), None) or (_seam(columns) if closed else None)


def discord(columns: Mapping[str, Floats]) -> Fault | None:
    """The first row, if there is one, where columns that say the same thing twice do not agree within what files round to."""
    return next(_faults(_agreement(columns)), None)


def ends_meet(columns: Mapping[str, Floats]) -> bool:
    """Whether the last row goes on as the first one, at the same speed and not from standstill."""
    return len(columns["s"]) > 2 and bool(columns["v"][0] > 0.0) and _seam(columns) is None


def _faults(rules: Iterator[Found]) -> Iterator[Fault]:
    for bad, name, values, expected in rules:
        if np.any(bad):
            row = int(np.argmax(bad))
            # rules for intervals name the row before
            yield Fault(row, f"{LABELS[name]} is {values[row]:.9g}, expected {expected.format(values[max(row - 1, 0)])}")


def _later(bad: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Rules for intervals complain about the row at the end."""
    return np.append(False, bad)


def _numbers(columns: Mapping[str, Floats], names: Iterable[str]) -> Iterator[Found]:
    for name in names:
        yield ~(np.abs(columns[name]) < LARGEST), name, columns[name], f"a finite number below {LARGEST:g}"


def _given(columns: Mapping[str, Floats]) -> Iterator[Found]:
    yield from _numbers(columns, (name for name in columns if name not in _FOLLOWING))
    s, v, psi = (columns[name] for name in ("s", "v", "psi"))
    yield _later(np.diff(s) < CLOSEST), "s", s, f"more than {{:.9g}} m of the row before, by {CLOSEST:g} m at least"
    yield v < 0.0, "v", v, "0 or more"
    yield _later(v[1:] + v[:-1] <= 0.0), "v", v, "a speed, since the one before is zero too and time would not end"
    yield _later(np.abs(np.diff(psi)) >= np.pi), "psi", psi, "a heading that goes on from {:.6g} rad of the row before by less than half a turn"
    yield np.abs(columns["bank"]) >= 0.5 * np.pi, "bank", columns["bank"], "a bank in rad, less than a right angle"


def _derived(columns: Mapping[str, Floats]) -> Iterator[Found]:
    yield from _numbers(columns, _FOLLOWING)
    yield _later(np.diff(columns["t"]) <= 0.0), "t", columns["t"], "more than {:.9g} s of the row before"


def _seam(columns: Mapping[str, Floats]) -> Fault | None:
    for name in ("x", "y", "z", "psi", "kappa", "v"):
        values = columns[name]
        gap = float(values[-1] - values[0])
        if name == "psi":
            gap = float(np.remainder(gap + np.pi, 2.0 * np.pi) - np.pi)
        if not abs(gap) <= SEAM:
            turns = " and full turns" if name == "psi" else ""
            text = f"{LABELS[name]} is {values[-1]:.9g}, expected {values[0]:.9g}{turns} as in the first row of a closed track"
            return Fault(len(values) - 1, text)
    return None


def _agreement(columns: Mapping[str, Floats]) -> Iterator[Found]:
    s, x, y, psi, kappa, v, a, t = (columns[name] for name in ("s", "x", "y", "psi", "kappa", "v", "a", "t"))
    h, moved, turned = np.diff(s), np.hypot(np.diff(x), np.diff(y)), np.diff(psi)
    yield _later(moved > h * (1.0 + _SHARE) + _ROUNDING), "s", s, "to grow from {:.9g} by no less than the points are apart"
    straight = moved > np.maximum(2.0 * _ROUNDING, 0.5 * h)
    aside = np.arctan2(np.diff(y), np.diff(x)) - 0.5 * (psi[1:] + psi[:-1])
    off = np.abs(np.remainder(aside + np.pi, 2.0 * np.pi) - np.pi)
    yield _later((moved < 0.5 * h - _ROUNDING) | (straight & (off > _TURN))), "psi", psi, "a heading in rad from +x to +y along the points"
    bent = 0.5 * h * (kappa[1:] + kappa[:-1])
    yield _later(np.abs(turned - bent) > _TURN), "kappa", kappa, "in 1/m, positive to the left, what the heading turns by"
    lasted = 2.0 * h / (v[1:] + v[:-1])
    yield _later(np.abs(np.diff(t) - lasted) > _SHARE * lasted + _ROUNDING), "t", t, "{:.9g} s and the way since over the mean of both speeds"
    gained = np.diff(v**2)
    # the last row has no interval
    bad = np.abs(2.0 * h * a[:-1] - gained) > _SHARE * np.abs(gained) + 2.0 * h * _ROUNDING + _ROUNDING * (v[1:] + v[:-1])
    yield np.append(bad, False), "a", a, "the change of v^2 up to the next row over twice the way"
