"""On-board supply: DC/DC converter M7 and low-voltage backup battery M8.

The converter's law is not printed in the source; it is taken as affine, P_HV = P_LV / eta + P_0. The backup battery is a constant voltage behind
a resistance with one thermal node.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..description.sections import Electrics

_SECONDS_PER_HOUR = 3600.0


def converter_input(electrics: Electrics, power: Any) -> Any:
    """Power in W that the DC/DC converter draws from the traction battery to deliver `power` (W, not negative) at low voltage."""
    return power / electrics.converter_efficiency + electrics.converter_constant_w


def converter_loss(electrics: Electrics, power: Any) -> Any:
    """Loss of the converter in W when it delivers `power` (W, not negative)."""
    return converter_input(electrics, power) - power


class BackupFlow(NamedTuple):
    """What a power does to the backup battery: power in W, positive when it discharges."""

    current: Any
    loss: Any
    soc_rate: Any
    temperature_rate: Any


def backup_flow(electrics: Electrics, power: Any, temperature: Any, ambient: Any) -> BackupFlow:
    """Current, loss, d soc/dt and dT/dt of the backup battery that gives `power` in W (negative: is charged).

    The current is the smaller root of (U - R i) i = P. Beyond the largest power U^2 / 4R the current stays at the one of that power.
    """
    p = electrics
    root = np.sqrt(np.fmax(p.voltage_v**2 - 4.0 * p.backup_resistance_ohm * power, 0.0))
    current = (p.voltage_v - root) / (2.0 * p.backup_resistance_ohm)
    loss = p.backup_resistance_ohm * current**2
    charge = max(p.backup_capacity_ah, 1e-9) * _SECONDS_PER_HOUR
    cooling = (temperature - ambient) / p.backup_thermal_resistance_kpw
    return BackupFlow(current, loss, -current / charge, (loss - cooling) / p.backup_heat_capacity_jpk)
