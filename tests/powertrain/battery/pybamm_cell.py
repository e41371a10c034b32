"""A PyBaMM cell on the virtual bench: an electrochemical model as independent truth."""

from __future__ import annotations

import os
import warnings

import numpy as np

os.environ["PYBAMM_DISABLE_TELEMETRY"] = "true"
#: How fast the current goes from one held value to the next, s.
_RAMP = 0.01


class PybammCell:
    """An isothermal particle model, currents scaled so that `capacity_ah` stands for the parameter set's nominal capacity."""

    def __init__(self, parameters: str = "Ecker2015", capacity_ah: float = 40.0, model: str = "SPMe") -> None:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            import pybamm
        pybamm.set_logging_level("CRITICAL")
        self.pybamm, self.parameters, self.model, self.capacity_ah = pybamm, parameters, model, capacity_ah
        values = pybamm.ParameterValues(parameters)
        self.scale = float(values["Nominal cell capacity [A.h]"]) / capacity_ah
        self.limits = float(values["Lower voltage cut-off [V]"]), float(values["Upper voltage cut-off [V]"])

    def _simulation(self, soc: float, temperature: float, given: dict, options: dict | None = None):
        pybamm = self.pybamm
        values = pybamm.ParameterValues(self.parameters)
        values.set_initial_state(soc)  # by the set's own voltage limits, before they are moved out of the way
        values.update({"Ambient temperature [K]": temperature, "Initial temperature [K]": temperature})
        values.update({"Lower voltage cut-off [V]": self.limits[0] - 0.5, "Upper voltage cut-off [V]": self.limits[1] + 0.6})
        values.update(given, check_already_exists=False)
        mesh = {"x_n": 8, "x_s": 5, "x_p": 8, "r_n": 16, "r_p": 16}
        model = getattr(pybamm.lithium_ion, self.model)(options)
        return pybamm.Simulation(model, parameter_values=values, var_pts=mesh, solver=pybamm.IDAKLUSolver(rtol=1e-4, atol=1e-6))

    def run(self, time: np.ndarray, current: np.ndarray, temperature: float, soc: float = 1.0) -> np.ndarray:
        """Voltage at each sample; ends at the lower limit, and at the upper one when charging slowly (short strong pulses may pass it)."""
        change = np.flatnonzero(np.diff(current)) + 1
        knots = np.concatenate([[time[0]], np.column_stack([time[change], time[change] + _RAMP]).ravel(), [time[-1] + 10.0]])
        levels = np.concatenate([[current[0]], np.column_stack([current[change - 1], current[change]]).ravel(), [current[-1]]])
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            given = self.pybamm.Interpolant(knots, self.scale * levels, self.pybamm.t)
            simulation = self._simulation(soc, temperature, {"Current function [A]": given})
            wanted = time + 2.0 * _RAMP  # the voltage of a sample is that of its own current
            solution = simulation.solve(t_eval=np.unique([time[0], *time[change], wanted[-1]]), t_interp=wanted)
            voltage = np.asarray(solution["Voltage [V]"](wanted[wanted <= solution.t[-1]]))
        drawn = current[: len(voltage)]
        slow = (drawn < 0.0) & (drawn > -0.2 * self.capacity_ah)
        out = np.flatnonzero((voltage < self.limits[0]) | (slow & (voltage > self.limits[1])))
        return voltage[: int(out[0])] if len(out) else voltage

    def hold_power(self, soc: float, power: float, temperature: float, horizon: float) -> np.ndarray:
        """Voltage while `power` (W, positive on discharge) is held from rest at `soc`; nothing cuts it off."""
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            simulation = self._simulation(soc, temperature, {"Power function [W]": self.scale * power}, {"operating mode": "power"})
            solution = simulation.solve(t_eval=[0.0, horizon], t_interp=np.linspace(0.01, horizon, int(10 * horizon)))
            return np.asarray(solution["Voltage [V]"].entries)
