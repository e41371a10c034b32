"""Cells and their parts made without a file are checked as those from one."""

import msgspec
import numpy as np
import pytest

from powertrain import VehicleError
from powertrain.battery import Esc, Mesc, Pair, Validity

from .conftest import LIMITS, make


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"capacity_ah": -5.0}, "Cell.capacity_ah is -5.0, expected float > 0"),
        ({"capacity_ah": np.nan}, "capacity_ah is nan"),
        ({"capacity_ah": np.float64(0.0)}, "capacity_ah is 0.0"),
        ({"coulombic_efficiency": 1.5}, "coulombic_efficiency is 1.5"),
        ({"heat_capacity_jpk": 0.0}, "heat_capacity_jpk is 0"),
        ({"hysteresis_rate": np.inf}, "hysteresis_rate is inf"),
        ({"ocv_v": 3.7}, "ocv_v is 3.7"),
    ],
)
def test_a_cell_made_by_hand_is_checked_as_one_from_a_file(change, says):
    with pytest.raises(VehicleError, match=says) as error:
        make("rc", **change)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("wrong", "says"),
    [
        (lambda: Validity(soc=(0.0, 1.0), temperature_degc=(5.0, 45.0), current_a=(np.nan, 10.0)), "current_a is"),
        (lambda: Validity(soc=(0.0, 1.0), temperature_degc=(5.0, 45.0), current_a=(10.0, -10.0)), "current_a is"),
        (lambda: Validity(soc=(0.0, 1.0), temperature_degc=(45.0, 5.0), current_a=(-1.0, 1.0)), "temperature_degc is"),
        (lambda: Esc(ohmic_ohm=-0.1, resistance_ohm=0.0, pole_radps=1.0), "ohmic_ohm is -0.1"),
        (lambda: Pair(resistance_ohm=0.1, time_constant_s=np.nan), "time_constant_s is nan"),
        (lambda: Mesc(pole_radps=(1.0, 1.0, 0.0, 1.0), resistance_ohm=0.1), "pole_radps is"),
        (lambda: msgspec.structs.replace(LIMITS, voltage_min_v=np.nan), "voltage_min_v is nan"),
    ],
)
def test_parts_of_a_cell_made_by_hand_are_checked(wrong, says):
    with pytest.raises(VehicleError, match=says):
        wrong()
