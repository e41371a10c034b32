"""A pack driven at what it promises: every cell, at its own share of the current, keeps its limits."""

from dataclasses import replace

import numpy as np
import pytest

from powertrain import VehicleError
from powertrain.battery import Pack, available_power, load_cell, pack_power, rest
from powertrain.battery.cell import frozen_at

from .conftest import LIMITS, make

WARM = 298.15


def unequal(cell, resistance, soc_offset=None, capacity=None) -> Pack:
    r = np.array(resistance, dtype=float)
    offset = np.zeros(r.shape) if soc_offset is None else np.array(soc_offset)
    return Pack(cell, np.ones(r.shape) if capacity is None else np.array(capacity), r, offset)


def driven(pack: Pack, state, power: float, horizon: float, steps: int = 40):
    """Largest and smallest current of a cell and voltage of a group while the pack holds a power: `Pack.step` in small steps."""
    pack = replace(pack, cell=frozen_at(pack.cell, WARM))  # the same, quicker
    current = power / pack.voltage(state, power / pack.voltage(state, 0.0))
    currents, voltages = [], []
    for _ in range(steps + 1):
        for _ in range(3):
            current = power / pack.voltage(state, current)
        each, group = pack.split(state, current)
        currents.append(each)
        voltages.append(group)
        state = pack.step(state, current, WARM, horizon / steps)
    return np.max(currents), np.min(currents), np.max(voltages), np.min(voltages)


PACKS = {
    "parallel": ([[0.7, 1.3]], None, None),
    "parallel, offset": ([[0.8, 1.2], [1.1, 1.0]], [[0.02, -0.02], [0.0, 0.01]], [[1.0, 0.9], [1.1, 1.0]]),
    "series, offset": ([[1.0], [1.3], [0.9]], [[0.03], [-0.03], [0.0]], None),
}


@pytest.mark.parametrize("horizon", [10.0, 20.0])
@pytest.mark.parametrize("soc", [0.12, 0.5, 0.9])
@pytest.mark.parametrize("which", list(PACKS))
def test_no_cell_leaves_its_current_or_voltage_when_the_pack_is_driven_at_the_promise(which, soc, horizon):
    cell = load_cell("nmc_40ah")
    pack, p = unequal(cell, *PACKS[which]), cell.limits
    state = pack.rest(soc, WARM)
    down, up, _ = pack_power(pack, state, horizon=horizon, margin=0.0)
    strongest, weakest = (p.discharge_peak_a, p.charge_peak_a) if horizon <= 10.0 else (p.discharge_max_a, p.charge_max_a)
    highest, _, _, lowest = driven(pack, state, down, horizon)
    assert highest <= strongest * (1.0 + 1e-3)
    assert lowest >= p.voltage_min_v - 2e-3
    _, lowest, highest, _ = driven(pack, state, -up, horizon)
    assert lowest >= -weakest * (1.0 + 1e-3)
    assert highest <= p.voltage_max_v + 2e-3


def test_the_promise_is_not_far_below_what_the_pack_can_do():
    """One percent more and a limit is broken."""
    cell = load_cell("nmc_40ah")
    pack = unequal(cell, *PACKS["parallel"])
    state = pack.rest(0.5, WARM)
    down, up, weakest = pack_power(pack, state, margin=0.0)
    assert driven(pack, state, 1.01 * down, 10.0)[0] > cell.limits.discharge_peak_a
    assert driven(pack, state, -1.01 * up, 10.0)[1] < -cell.limits.charge_peak_a
    assert weakest == (0, 0)


@pytest.mark.parametrize("kind", ["mesc", "mesc-taps", "esc", "rc"])
@pytest.mark.parametrize("soc", [0.06, 0.5, 0.93])
def test_equal_cells_have_the_power_of_one_times_their_number_or_a_little_less(kind, soc):
    cell = make(kind)
    alone = available_power(cell, rest(cell, soc), WARM, horizons=(10.0,))
    shape = (3, 1) if kind == "mesc" else (3, 2)
    pack = unequal(cell, np.ones(shape))
    down, up, _ = pack_power(pack, pack.rest(soc, WARM))
    least = 0.92 if kind == "mesc" else 0.97  # its voltage lags behind the current, so the power at the start is the larger
    assert least < down / (pack.capacity.size * alone.discharge[0].power) < 1.002
    assert least < up / (pack.capacity.size * alone.charge[0].power) < 1.002


def test_a_pack_promises_nothing_where_its_cells_were_not_identified_or_one_is_too_hot():
    cell = make("rc")
    pack = unequal(cell, np.ones((2, 2)))
    assert pack_power(pack, pack.rest(0.5, 268.15))[:2] == (0.0, 0.0)
    assert pack_power(pack, pack.rest(0.5, 268.15), extrapolate=True)[0] > 0.0
    hot = pack.rest(0.5, WARM)
    hot[-1][1, 0] = LIMITS.temperature_max_degc + 273.15 + 1.0
    assert pack_power(pack, hot, extrapolate=True) == (0.0, 0.0, (1, 0))


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"soc": 1.2}, "soc is"),
        ({"soc": np.nan}, "finite"),
        ({"horizon": 0.0}, "horizon"),
        ({"kind": "mesc"}, "without ohmic resistance"),
    ],
)
def test_a_question_that_makes_no_sense_is_refused(change, says):
    pack = unequal(make(change.get("kind", "rc")), np.ones((2, 2)))
    state = pack.rest(0.5, WARM)
    state[0][:] = change.get("soc", 0.5)
    with pytest.raises(VehicleError, match=says):
        pack_power(pack, state, horizon=change.get("horizon", 10.0))
