"""What a cell close to its warmest temperature can give: the heat of its resistances has closed forms."""

import numpy as np
import pytest

from powertrain.battery import Cell, Pack, Pair, Rc, available_power, pack_power

from .conftest import LIMITS, make

OHMIC, PAIR = 0.001, 0.004
HORIZON, CAPACITY = 10.0, 300.0
#: K that are left until the warmest temperature
ROOM = 0.05
START = 273.15 + LIMITS.temperature_max_degc - ROOM


def cell_of(time_constant: float) -> Cell:
    pair = Pair(resistance_ohm=PAIR, time_constant_s=time_constant)
    return make("rc", rc=Rc(ohmic_ohm=OHMIC, pairs=(pair,)), hysteresis_v=0.0, hysteresis_rate=0.0, heat_capacity_jpk=CAPACITY)


def test_a_current_that_still_flows_through_a_slow_pair_heats_by_its_own_square():
    # a pair so slow that its current stays: R0 i^2 + R1 f^2 fills the room in ten seconds, whatever the direction of i
    flowing = 15.0
    current = np.sqrt((ROOM * CAPACITY / HORIZON - PAIR * flowing**2) / OHMIC)
    found = available_power(cell_of(1e6), [0.5, 0.0, flowing], START, horizons=(HORIZON,), extrapolate=True)
    for answer in (found.discharge[0], found.charge[0]):
        assert answer.current_limit == "temperature"
        # the answer is known to 1 / 9216 of the largest conceivable current, 160 A
        assert current - 0.03 < answer.current <= current * (1.0 + 1e-4)


@pytest.mark.parametrize("time_constant", [2.0, 20.0])
def test_what_is_promised_from_rest_warms_the_cell_to_its_limit_and_no_further(time_constant: float):
    cell, w = cell_of(time_constant), 1.0 / time_constant
    # f = i (1 - exp(-w t)), its square integrated
    share = HORIZON - 2.0 * (1.0 - np.exp(-w * HORIZON)) / w + (1.0 - np.exp(-2.0 * w * HORIZON)) / (2.0 * w)
    current = np.sqrt(ROOM * CAPACITY / (OHMIC * HORIZON + PAIR * share))
    answer = available_power(cell, [0.5, 0.0, 0.0], START, horizons=(HORIZON,), extrapolate=True).discharge[0]
    assert answer.current_limit == "temperature"
    # twenty steps, over which the filter is taken as straight, miss the heat by some thousandths; current goes with its root
    assert answer.current == pytest.approx(current, rel=2e-3)
    ones = np.ones((2, 1))
    pack = Pack(cell, ones, ones, 0.0 * ones)
    power = pack_power(pack, pack.rest(0.5, START), horizon=HORIZON, extrapolate=True)[0]
    # the pack's power is its largest current, known to 1 / 1024 of 160 A, at the lowest voltage on the way: that of the end but for the last digits
    after = [0.5 - current * HORIZON / cell.capacity, 0.0, current * (1.0 - np.exp(-w * HORIZON))]
    end = float(cell.ocv_v(after[0])) - PAIR * after[2] - OHMIC * current
    assert power == pytest.approx(2.0 * current * end, rel=6e-3)
