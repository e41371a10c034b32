"""Guard and observer on a car that turns, slides and changes all its velocities at once, while several fixes of a late receiver are on their way."""

import math
from dataclasses import dataclass

import numpy as np
import pytest

from energy_mgr.manager import DeadReckoning, Measurements, Trust
from energy_mgr.manager.guard import Guard
from tests.energy_mgr.manager.rig import DT

#: The first fixes are as old as this already, s; those that follow come every fifth of a second.
LATE = 0.6


@dataclass(frozen=True)
class Motion:
    """x, y, psi, v_x, v_y, yaw rate and the accelerations of the centre of gravity at times in steps of `DT`, from smooth velocities."""

    rows: np.ndarray

    @classmethod
    def of(cls, seconds: float) -> "Motion":
        # places by the midpoint rule in steps of a tenth of the period: right to micrometres
        fine = DT / 10
        t = fine * np.arange(round(seconds / fine) + 1)
        v = 9.0 + 2.0 * np.sin(0.9 * t) + 1j * (0.8 * np.sin(1.3 * t + 0.4) - 0.5)
        turn = 0.35 + 0.3 * np.sin(1.1 * t + 1.0)
        gained = 1.8 * np.cos(0.9 * t) + 1j * 1.04 * np.cos(1.3 * t + 0.4) + 1j * turn * v
        psi = 2.5 + np.concatenate([[0.0], np.cumsum(0.5 * fine * (turn[1:] + turn[:-1]))])
        moving = v * np.exp(1j * psi)
        place = 30.0 - 12.0j + np.concatenate([[0.0], np.cumsum(0.5 * fine * (moving[1:] + moving[:-1]))])
        return cls(np.array([place.real, place.imag, psi, v.real, v.imag, turn, gained.real, gained.imag]).T[::10])

    def measured(self, t: float, fix: float, **more: float) -> Measurements:
        """Velocities of `t`, place and heading of the time `fix`; the heading within half a turn, as receivers tell it."""
        now, then = self.rows[round(t / DT)].tolist(), self.rows[round(fix / DT)].tolist()
        return Measurements(t, then[0], then[1], math.remainder(then[2], math.tau), *now[3:], pose_time=fix)._replace(**more)


MOTION = Motion.of(8.0)
TIMES = [round(LATE / DT) * DT + DT * k for k in range(1500)]


def fix_time(t: float, late: float) -> float:
    """When the newest fix that has arrived at `t` was true: every 0.2 s, `late` on its way."""
    return max(DT * round(0.2 * math.floor((t - late) / 0.2 + 1e-9) / DT), 0.0)


@pytest.mark.parametrize("late", [0.0, 0.2, LATE])
def test_a_sliding_turning_car_is_where_the_observer_says_whatever_is_on_its_way(late: float):
    observer = DeadReckoning()
    for t in TIMES:
        found = observer.update(MOTION.measured(t, fix_time(t, late)), t)
        x, y, psi, v_x, v_y, turn = MOTION.rows[round(t / DT)].tolist()[:6]
        # velocities of a period's end for the whole of it: 2 ms of 4 m/s^2 aside; the yaw rate smoothed over 20 ms of 0.33 rad/s^2
        assert abs(found.v_x - v_x) < 0.02
        assert abs(found.v_y - v_y) < 0.02
        assert abs(found.yaw_rate - turn) < 0.01
        # the first place is up to 1.3 m off; 0.7 of that are left after each fix. 5 cm and 6 mrad were found later on
        if t > TIMES[0] + 2.0 + 2.0 * late:
            assert math.hypot(found.x - x, found.y - y) < 0.06
            assert abs(math.remainder(found.psi - psi, math.tau)) < 0.015


def test_from_its_first_fix_alone_the_observer_goes_on_from_where_the_car_was():
    """The first place is carried on over the time that it was on its way with the velocities of now: wrong by what these have changed since."""
    start = round(LATE / DT) * DT
    for fix in (start, start - 0.1, start - 0.3):
        late = start - fix
        found = DeadReckoning().update(MOTION.measured(start, fix), start)
        x, y, psi = MOTION.rows[round(start / DT)].tolist()[:3]
        # at most 4.5 m/s^2 and 0.33 rad/s^2, each over half the time squared; the heading turns the way itself, by half its angle
        assert math.hypot(found.x - x, found.y - y) < 0.5 * (4.5 + 10.0 * 0.6) * late**2 + 1e-3
        assert abs(math.remainder(found.psi - psi, math.tau)) < 0.5 * 0.4 * late**2 + 1e-3


def test_a_fix_that_is_off_moves_what_was_found_by_its_share_and_no_more():
    """Two alike but for one late fix, 2 m ahead and 0.1 rad turned: places differ by the gain, and those on their way do not count twice."""
    good, off = DeadReckoning(gain=0.3), DeadReckoning(gain=0.3)
    wrong = fix_time(TIMES[100], LATE)
    gaps = []
    for t in TIMES[:400]:
        fix = fix_time(t, LATE)
        m = MOTION.measured(t, fix)
        moved = m._replace(x=m.x + 2.0, y=m.y - 1.0, psi=m.psi + 0.1) if fix == wrong else m
        a, b = good.update(m, t), off.update(moved, t)
        gaps.append((b.x - a.x, b.y - a.y, math.remainder(b.psi - a.psi, math.tau)))
    first = next(k for k, gap in enumerate(gaps) if gap != (0.0, 0.0, 0.0))
    assert gaps[first] == pytest.approx((0.6, -0.3, 0.03), abs=1e-9)
    # after each good fix 0.7 of the heading's error are left, with those on their way corrected by what was wrong when they were true
    assert gaps[first + 55][2] == pytest.approx(0.03 * 0.7, abs=1e-9)
    assert gaps[first + 105][2] == pytest.approx(0.03 * 0.49, abs=1e-9)


@pytest.mark.parametrize("late", [0.0, 0.2, LATE])
def test_the_guard_believes_a_sliding_turning_car_and_nothing_beside_it(late: float):
    # velocities are those of now, places those of the fix: 4.5 m/s^2 and 0.33 rad/s^2 over the lateness, for the fifth of a second between fixes
    trust = Trust(place=0.1 + 0.9 * late, heading=0.02 + 0.07 * late, speed=0.05, yaw_rate=0.02, acceleration=5.5)
    guard = Guard(trust, 4, 4, 4)
    for k, t in enumerate(TIMES):
        m = MOTION.measured(t, fix_time(t, late))
        if k % 50 == 25:
            memory = guard.snapshot()
            for name, size in {"x": 1.0, "y": -1.0, "psi": 0.3, "v_x": 0.3, "v_y": -0.3, "yaw_rate": 0.2}.items():
                wrong = m._replace(**{name: getattr(m, name) + size * (-1) ** k})
                assert guard.reason(wrong, t) == "jump", (name, t)
                guard.restore(memory)
        assert guard.reason(m, t) == "", t
    assert sum(guard.refused.values()) == 0


def test_without_times_of_fixes_speeds_headings_and_places_have_to_go_the_same_way():
    """Measured at once, the places of a sliding car follow from speeds and headings; with the side slip's sign lost they do not for long."""
    trust = Trust(place=0.1, drift=0.02, heading=0.03, speed=0.05, yaw_rate=0.02, acceleration=5.5)
    true, wrong, believed = Guard(trust, 4, 4, 4), Guard(trust, 4, 4, 4), 0
    for t in TIMES:
        m = MOTION.measured(t, t)._replace(pose_time=None)
        assert true.reason(m, t) == ""
        believed += not wrong.reason(m._replace(v_y=-m.v_y - 0.8), t)
    assert believed < len(TIMES)
