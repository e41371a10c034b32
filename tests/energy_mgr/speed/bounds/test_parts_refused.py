"""What parts, roads and ends are refused, in which words."""

from dataclasses import replace

import numpy as np
import pytest

from energy_mgr import PlanningError, SpeedLimits, plan_path
from energy_mgr.speed import Arrival, BatteryPower, Comfort, FrictionBrakes, Grip, Jerk, Lateral, SpeedCap, Stop
from energy_mgr.speed.bounds.parts import Part
from roads import Road, RoadBuilder, RoadError

from ..rig import ROMO, limits_of

INF, NAN = float("inf"), float("nan")

REFUSED = {
    "lateral zero": (Lateral(0.0), r"^lateral acceleration 0.0 m/s\^2, expected more than 0$"),
    "lateral nan": (Lateral(NAN), "lateral acceleration nan"),
    "lateral inf": (Lateral(INF), "lateral acceleration inf"),
    "acceleration": (Comfort(-1.0, 1.0), r"acceleration -1.0 m/s\^2, expected more than 0"),
    "deceleration": (Comfort(1.0, NAN), r"deceleration nan m/s\^2"),
    "acceleration nan": (Comfort(NAN, 1.0), r"acceleration nan m/s\^2"),
    "brakes": (FrictionBrakes(-5.0), "force of the friction brakes -5.0 N, expected more than 0"),
    "brakes nan": (FrictionBrakes(NAN), "force of the friction brakes nan N"),
    "friction": (Grip(0.0), "^friction 0.0, expected more than 0$"),
    "friction nan": (Grip(NAN), "friction nan"),
    "jerk": (Jerk(0.0), r"jerk 0.0 m/s\^3, expected more than 0"),
    "jerk nan": (Jerk(NAN), "jerk nan"),
    "discharge": (BatteryPower(-1.0, 1.0), "^rig: battery power is -1 W at s = 0.0 m, expected 0 or more$"),
    "charge nan": (BatteryPower(1.0, NAN), "battery power is nan W at s = 0.0 m"),
    "discharge inf": (BatteryPower(INF, 1.0), "battery power is inf W"),
    "stop before": (Stop(-1.0), "^rig: station -1 m asked for, expected 0 to 200.0 m$"),
    "stop beyond": (Stop(300.0), "station 300 m asked for, expected 0 to 200.0 m"),
    "stop nan": (Stop(NAN), "station nan m asked for"),
    "window order": (Arrival(50.0, 9.0, 4.0), "^rig: window at s = 50 m( of the path)? from 9 to 4 s, expected 0 <= earliest <= latest$"),
    "window past": (Arrival(50.0, -2.0, 4.0), "from -2 to 4 s"),
    "window nan": (Arrival(50.0, NAN, 4.0), "from nan to 4 s"),
    "window end nan": (Arrival(50.0, 1.0, NAN), "from 1 to nan s"),
    "window station nan": (Arrival(NAN, 1.0, 2.0), "station nan m asked for"),
    "cap order": (SpeedCap([50.0, 20.0], [1.0, 2.0]), "cap `cap` with stations of shape"),
    "cap shape": (SpeedCap([50.0, 60.0], [1.0]), r"stations of shape \(2,\), speeds \(1,\), expected increasing stations"),
    "cap empty": (SpeedCap([], []), r"stations of shape \(0,\)"),
    "cap nan": (SpeedCap([50.0], [NAN]), "^rig: speed limit `cap` is nan m/s at s = 50.0 m, expected 0 or more$"),
    "cap negative": (SpeedCap([50.0], [-3.0], "mine"), "speed limit `mine` is -3 m/s at s = 50.0 m"),
    "cap station nan": (SpeedCap([NAN], [3.0]), "station nan m asked for"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_numbers_that_make_no_sense_are_refused_with_their_place(case: str):
    part, words = REFUSED[case]
    with pytest.raises(PlanningError, match=words) as found:
        limits_of(extra=[part])
    assert "\n" not in str(found.value)


@pytest.mark.parametrize(
    ("part", "words"),
    [
        pytest.param(Arrival(100.0, INF, INF), "window at s = 100 m", id="window that never opens"),
        pytest.param(Arrival(0.0, 5.0, 10.0), "window at s = 0 m", id="window after the start"),
        pytest.param(BatteryPower(np.ones(7), 1e4), "battery power", id="powers of the wrong shape"),
    ],
)
def test_windows_and_powers_that_cannot_be_meant_are_refused(part: Part, words: str):
    with pytest.raises(PlanningError, match=words):
        limits_of(extra=[part])


def test_a_posted_limit_below_zero_is_refused_with_its_place():
    with pytest.raises(PlanningError, match="^rig: speed limit `posted` is -1 m/s at s = 40.0 m, expected 0 or more$"):
        limits_of(posted=lambda s: np.where(s > 44.0, -1.0, 20.0))


@pytest.mark.parametrize("what", ["speed_limit", "height", "bank", "friction"])
def test_a_road_with_a_value_that_is_no_number_is_refused_at_the_door(what: str):
    values = np.where(np.arange(60) == 30, NAN, 0.5)
    with pytest.raises(RoadError, match=f"{what.replace('_', '.')}.* at s = 150.0 m is nan"):
        Road.from_points("line", np.column_stack([5.0 * np.arange(60), np.zeros(60)]), -3.0, 3.0, **{what: values})


@pytest.mark.parametrize("bad", [NAN, -0.5, 0.0])
def test_accelerations_that_are_no_positive_numbers_are_refused_with_their_place(bad: float):
    limits = limits_of()
    wrong = limits.acceleration.copy()
    wrong[7] = bad
    with pytest.raises(PlanningError, match=r"acceleration limit is .* m/s\^2 at s = 35.0 m, expected more than 0"):
        replace(limits, acceleration=wrong).checked()
    with pytest.raises(PlanningError, match=r"deceleration limit is .* m/s\^2 at s = 35.0 m, expected more than 0"):
        replace(limits, deceleration=wrong).checked()


@pytest.mark.parametrize("step", [NAN, 0.0, -1.0, 2000.0])
def test_steps_out_of_range_are_refused(step: float):
    road = RoadBuilder("line").limit(15).straight(100).build()
    with pytest.raises(PlanningError, match="m between stations, expected 0.01 to 1000 m"):
        SpeedLimits.along(road, plan_path(road, 1.0, kind="lane", extent="road"), ROMO, step=step)


def test_banks_on_which_a_car_at_rest_cannot_stay_are_refused_with_the_amount():
    bank = {"bank": lambda s: np.where(s > 100.0, 0.5, 0.0), "length": 200.0}
    # 9.81 sin 0.5 = 4.70, tan 0.5 = 0.546
    with pytest.raises(PlanningError, match=r"^rig: bank at s = 100.2. m: lateral acceleration at rest is 4.70 m/s\^2, limit 3$|bank at s = 100"):
        limits_of(parts=[Lateral(3.0)], **bank)
    with pytest.raises(PlanningError, match="bank at s = 100.* m: the friction needed at rest is 0.546, more than there is"):
        limits_of(parts=[Grip(0.5)], **bank)


@pytest.mark.parametrize("value", [-1.0, 21.0, NAN, INF])
def test_speeds_at_the_ends_that_no_limit_allows_name_the_limit(value: float):
    with pytest.raises(PlanningError, match=r"start speed .* m/s at s = 0.0 m, expected 0 to 20.00 m/s there \(limit `posted`\)"):
        limits_of(start_speed=value)
    with pytest.raises(PlanningError, match=r"end speed .* m/s at s = 200.0 m, expected 0 to 20.00 m/s there \(limit `posted`\)"):
        limits_of(end_speed=value)


def test_jerk_on_a_circuit_is_refused_as_long_as_the_seam_has_none():
    with pytest.raises(PlanningError, match="rig: a limit of jerk needs an open road, this is a circuit"):
        limits_of(length=400.0, kappa=2 * np.pi / 400, closed=True, extra=[Jerk(1.0)])
