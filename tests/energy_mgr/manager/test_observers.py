"""Dead reckoning with fixes that come late: closed forms of how errors fade, and what is known at once."""

import math

import numpy as np
import pytest

from energy_mgr.manager import DeadReckoning, Measurements

DT = 0.004


def reckoned(v, yaw_rate, wrong, *, every=10, late=50, periods=500, gain=0.3):
    """Errors of x, y, psi after each period of steady motion; fixes every `every` periods come `late` periods late; the start is `wrong`.

    Velocities are true. Also how many fixes that were taken after the start had arrived.
    """
    observer, errors, arrived = DeadReckoning(gain=gain), [], []

    def truth(k):
        # along +x or, turning, along a circle
        psi = yaw_rate * DT * k
        if yaw_rate == 0.0:
            return v * DT * k, 0.0, 0.0
        return v / yaw_rate * math.sin(psi), v / yaw_rate * (1.0 - math.cos(psi)), psi

    for k in range(periods):
        taken = max((k - late) // every, 0) * every
        pose = truth(taken) if taken > 0 else tuple(a + b for a, b in zip(truth(0), wrong, strict=True))
        m = Measurements(DT * k, *pose, v, 0.0, yaw_rate, 0.0, v * yaw_rate, pose_time=DT * taken)
        state = observer.update(m, DT * k)
        errors.append(np.subtract(state[:3], truth(k)))
        arrived.append(taken // every)
    return np.array(errors), np.array(arrived)


@pytest.mark.parametrize(("v", "wrong"), [(0.0, (1.0, -2.0, 0.1)), (12.0, (1.0, -2.0, 0.0))], ids=["standing", "rolling"])
def test_an_error_of_the_start_fades_by_the_gain_with_every_fix_however_late(v, wrong):
    """Five fixes are on their way at any time. Each tells of an error that those before it have meanwhile taken 0.3 of: 0.7^n, and no overshoot.

    Where the places remembered are not corrected with the present one, each fix would count the same error again, and the estimate swings.
    """
    errors, arrived = reckoned(v, 0.0, wrong)
    assert arrived[-1] > 40
    expected = np.outer(0.7**arrived, wrong)
    # integrating 12 m/s in steps rounds in the last digits
    assert errors == pytest.approx(expected, abs=1e-9)


def test_in_a_bend_a_late_fix_corrects_the_place_where_it_was_true():
    """Right from the start, fixes 0.2 s and 2.4 m late: nothing is to be corrected, but for chords of 4 ms in place of arcs (1.3e-6 m a second)."""
    errors, arrived = reckoned(12.0, 0.4, (0.0, 0.0, 0.0))
    assert arrived[-1] > 40
    assert np.max(np.abs(errors[:, :2])) < 5e-6
    assert np.max(np.abs(errors[:, 2])) < 1e-12  # rounding of 500 sums


@pytest.mark.parametrize(("v_x", "v_y", "yaw_rate"), [(12.0, 0.8, 0.4), (12.0, -0.8, 0.4), (6.0, 1.5, -0.7)])
def test_a_car_that_slides_steadily_keeps_its_velocities(v_x, v_y, yaw_rate):
    """On a circle with side slip nothing changes in the car's frame: accelerations are the turning of the velocity, (-r v_y, r v_x)."""
    observer = DeadReckoning()
    for k in range(500):
        psi = yaw_rate * DT * k
        # the centre's velocity, turned by psi, integrated
        x, y = np.array([[math.sin(psi), math.cos(psi) - 1.0], [1.0 - math.cos(psi), math.sin(psi)]]) @ [v_x, v_y] / yaw_rate
        m = Measurements(DT * k, float(x), float(y), psi, v_x, v_y, yaw_rate, -yaw_rate * v_y, yaw_rate * v_x)
        state = observer.update(m, DT * k)
        # 500 sums of numbers of this size
        assert (state.v_x, state.v_y, state.yaw_rate) == pytest.approx((v_x, v_y, yaw_rate), abs=1e-11)
