"""Roads of a few stations with every kind of limit, short enough for SciPy."""

import numpy as np

from energy_mgr.speed import BatteryPower, Comfort, FrictionBrakes, Grip, Lateral, Motors, Posted, SpeedLimits
from energy_mgr.speed.bounds.parts import Part

from .rig import ROMO, changed, limits_of

WEAK = changed(ROMO, drive={"power_max_w": 4e3, "regen_power_max_w": 3e3})
HILL = {"height": lambda s: 1.5 * np.sin(s / 18.0), "kappa": lambda s: 0.02 * np.sin(s / 11.0), "bank": lambda s: 0.03 * np.sin(s / 9.0)}


def tiny(vehicle=WEAK, extra: tuple[Part, ...] = (), *, count: int = 9, closed: bool = False, start: float = 0.0, end: float = 0.0) -> SpeedLimits:
    way = {**HILL, "kappa": 2 * np.pi / 72.0, "height": lambda s: 1.0 * np.sin(2 * np.pi * s / 72.0)} if closed else HILL
    parts = [Posted(), Lateral(), Comfort(), Motors(), *extra]
    s = np.unique(np.concatenate([np.linspace(0.0, 72.0, count), *[np.asarray(part.stations, dtype=float) for part in parts]]))
    return limits_of(vehicle, parts=parts, s=s, closed=closed, start_speed=start, end_speed=end, posted=12.0, **way)


KINDS: dict[str, tuple[Part, ...]] = {
    "plain": (),
    "brakes": (FrictionBrakes(2000.0),),
    "grip": (Grip(0.5),),
    "battery": (BatteryPower(8e3, 4e3),),
    "all": (FrictionBrakes(2000.0), Grip(0.5), BatteryPower(8e3, 4e3)),
}
