import msgspec
import numpy as np
import pytest

from energy_mgr import InfeasibleError, PlanningError, SpeedLimits, plan_path
from energy_mgr.speed import FrictionBrakes, battery_profile, fastest_profile
from energy_mgr.speed.battery import battery_powers, instant_powers
from energy_mgr.speed.result import energy_of
from powertrain import load_vehicle
from powertrain.battery import available_power, load_cell, states
from powertrain.description.sections import Battery
from powertrain.drive.supply import converter_input
from roads import RoadBuilder

ROMO = load_vehicle("romo")
LEAST = load_cell("nmc_40ah").limits.soc_min


def straight(length: float = 1500.0, slope: float = 0.0, *extra) -> SpeedLimits:
    road = RoadBuilder("straight").limit(20.0).straight(length).build(height=lambda s: slope * s)
    return SpeedLimits.along(road, plan_path(road, 1.0, kind="lane", extent="road"), ROMO, extra=extra, step=5.0)


def test_powers_are_those_of_the_cells_times_their_number():
    cell, battery = load_cell("nmc_40ah"), ROMO.need("battery", Battery)
    found = available_power(cell, [0.55, *[0.0] * (len(states(cell)) - 1)], 298.15, horizons=(10.0,))
    give, take = battery_powers(ROMO, np.array([0.55]))
    # linear between charges a tenth apart
    assert give[0] == pytest.approx(90 * battery.parallel * found.discharge[0].power, rel=0.02)
    assert take[0] == pytest.approx(90 * battery.parallel * found.charge[0].power, rel=0.02)


def test_powers_shrink_as_the_charge_falls_and_vanish_at_the_least():
    give, take = battery_powers(ROMO, np.array([LEAST, LEAST + 0.005, 0.1, 0.9, 1.0]))
    assert give[0] == 0.0
    assert np.all(np.diff(give) > 0.0)
    assert take[-1] == 0.0
    assert instant_powers(ROMO, LEAST)[0] == 0.0


def test_instant_powers_are_those_of_all_cells_in_a_row_and_side_by_side():
    found = {}
    for series, parallel in ((90, 1), (90, 3), (30, 1)):
        car = msgspec.structs.replace(ROMO, battery=msgspec.structs.replace(ROMO.need("battery", Battery), series=series, parallel=parallel))
        found[series, parallel] = np.array(instant_powers(car, 0.5))
    assert np.all(found[90, 1] > 0.0)
    # equal cells give equal powers, however they are joined
    assert found[90, 3] == pytest.approx(3.0 * found[90, 1], rel=1e-12)
    assert found[30, 1] == pytest.approx(found[90, 1] / 3.0, rel=1e-12)


def test_a_full_enough_battery_changes_nothing_and_charge_adds_up():
    limits = straight()
    journey = 1.2 * fastest_profile(limits).journey_time
    drive = battery_profile(limits, journey, 0.6)
    assert drive.put_off < 1e-3
    terminals = energy_of(limits, drive.profile).total
    auxiliary = converter_input(ROMO.electrics, ROMO.electrics.auxiliary_w) * drive.profile.journey_time
    assert drive.charge.energy == pytest.approx(terminals + auxiliary, rel=1e-6)
    assert drive.soc[0] - drive.soc[-1] == pytest.approx(drive.charge.charge_ah / 40.0, rel=0.05)


def test_the_arrival_is_put_off_until_the_charge_lasts():
    limits = straight()
    journey = 1.02 * fastest_profile(limits).journey_time
    needed = battery_profile(limits, journey, 0.5)
    thrifty = battery_profile(limits, None, 0.5, price=0.0)
    start = LEAST + 0.5 * ((needed.soc[0] - needed.soc[-1]) + (thrifty.soc[0] - thrifty.soc[-1]))
    drive = battery_profile(limits, journey, start)
    assert drive.put_off > 1.0
    assert np.min(drive.soc) >= LEAST
    assert drive.charge.shortage is None
    assert journey < drive.profile.journey_time < thrifty.profile.journey_time


def test_a_price_of_time_is_followed_as_far_as_the_charge_lasts():
    limits = straight()
    eager = battery_profile(limits, None, 0.5, price=2e4)
    slow = battery_profile(limits, None, 0.5, price=0.0)
    start = LEAST + 0.6 * (eager.soc[0] - eager.soc[-1]) + 0.4 * (slow.soc[0] - slow.soc[-1])
    drive = battery_profile(limits, None, start, price=2e4)
    assert eager.profile.journey_time < drive.profile.journey_time < slow.profile.journey_time


def test_an_empty_battery_says_where_and_how_much_is_missing():
    limits = straight()
    thrifty = battery_profile(limits, None, 0.5, price=0.0)
    start = LEAST + 0.5 * (thrifty.soc[0] - thrifty.soc[-1])
    with pytest.raises(
        InfeasibleError, match=r"is empty at s = \d+\.\d m of 1500\.0 m even when driven as thriftily as can be: 0\.\d+ kWh are missing"
    ):
        battery_profile(limits, 120.0, start)
    with pytest.raises(InfeasibleError, match=r"state of charge 0\.050 at the start, expected more than the least of ROMO.s battery, 0\.050"):
        battery_profile(limits, 120.0, LEAST)


def test_a_full_battery_goes_downhill_on_its_friction_brakes():
    limits = straight(800.0, -0.06, FrictionBrakes())
    drive = battery_profile(limits, 1.3 * fastest_profile(limits).journey_time, 1.0)
    assert drive.profile.brake is not None
    # what the slope gives and drag and rolling do not take has nowhere to go but the brakes
    assert np.sum(drive.profile.brake * limits.ds) > 1e5
    assert np.max(drive.soc) <= 1.0 + 1e-9
    # without them it creeps down at the speed at which losses take up what the slope gives
    assert battery_profile(straight(800.0, -0.06), 60.0, 1.0).put_off > 30.0


@pytest.mark.parametrize("soc", [-0.1, 1.1, float("nan")])
def test_charges_that_are_none_are_refused(soc: float):
    with pytest.raises(PlanningError, match="charge .*, expected 0 to 1"):
        battery_profile(straight(), 120.0, soc)
