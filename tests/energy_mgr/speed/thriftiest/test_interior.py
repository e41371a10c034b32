"""The interior-point method against SciPy on roads so short that both can be trusted."""

from typing import NamedTuple

import numpy as np
import pytest
from scipy.optimize import minimize

from energy_mgr.speed import (
    Arrival,
    BatteryPower,
    EcoSolver,
    FrictionBrakes,
    Grip,
    Jerk,
    SpeedCap,
    SpeedLimits,
    Stop,
    eco_profile,
    fastest_profile,
)
from energy_mgr.speed.bounds.jerk import JerkModel, jerk_of
from energy_mgr.speed.bounds.parts import Part
from energy_mgr.speed.thriftiest.interior import ChainProgramme
from energy_mgr.speed.thriftiest.interval import IntervalModel
from energy_mgr.speed.thriftiest.iterate import Deadline
from powertrain import drive_energy

from ..rig import ROMO, VAN, changed
from ..tiny_roads import KINDS, WEAK, tiny


class Case(NamedTuple):
    vehicle: object
    extra: tuple[Part, ...]
    factor: float
    closed: bool = False
    start: float = 0.0
    end: float = 0.0


CASES = {
    "plain": Case(ROMO, (), 1.2),
    "weak": Case(WEAK, (), 1.1),
    "barely": Case(ROMO, (), 1.02),
    "rolling start": Case(ROMO, (), 1.15, False, 6.0, 4.0),
    "brakes": Case(changed(ROMO, drive={"regen_torque_max_nm": 20.0}), (FrictionBrakes(2000.0),), 1.1),
    "grip": Case(ROMO, (Grip(0.35),), 1.1),
    "battery": Case(ROMO, (BatteryPower(9e3, 4e3),), 1.15),
    "jerk": Case(ROMO, (Jerk(0.9),), 1.3),
    "stop": Case(ROMO, (Stop(36.0),), 1.15),
    "cap": Case(VAN, (SpeedCap([20.0, 40.0], [5.0, 30.0]),), 1.2),
    "window": Case(ROMO, (Arrival(36.0, 0.0, 7.6),), 1.15),
    "late window": Case(ROMO, (Arrival(36.0, 10.0, 40.0),), 1.25),
    "circuit": Case(WEAK, (), 1.2, True),
}


def reference(limits: SpeedLimits, journey_time: float, v0: np.ndarray) -> tuple[float, np.ndarray]:
    """Least energy by SLSQP over v^2/2 and the braking forces: drive_energy itself, every limit from its definition."""
    count, scale = len(limits.s), float(np.max(limits.energy_max))
    car, ds = limits.vehicle, limits.ds
    bound = limits.energy_max / scale
    if limits.closed:
        bound[[0, -1]] = min(bound[0], bound[-1])
    braking = limits.brake > 0.0
    unit = car.effective_mass * scale

    def parts(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return np.sqrt(2.0 * scale * np.maximum(x[:count], 0.0)), (np.maximum(x[count:], 0.0) * 1e3 if braking else np.zeros_like(ds))

    def energy(x: np.ndarray) -> float:
        v, brake = parts(x)
        return drive_energy(car, limits.s, v, limits.z, brake).total / unit

    def rows(x: np.ndarray) -> np.ndarray:
        v, brake = parts(x)
        gain = np.diff(v**2) / (2.0 * ds)
        found = [gain - limits.acceleration, -gain - limits.deceleration]
        for end in (v[:-1], v[1:]):
            wheels = car.effective_mass * gain + limits.resistance(end)
            for limit in limits.forces:
                force = wheels + brake if limit.of == "motors" else wheels
                found.append(np.asarray(limit.excess(car, force, end, limit.data)) + 0.0 * gain)
        times = np.concatenate([[0.0], np.cumsum(2.0 * ds / (v[1:] + v[:-1]))])
        found.append([times[-1] / journey_time - 1.0])
        for window in limits.windows:
            t = times[int(np.argmin(np.abs(limits.s - window.s)))]
            found += [[t - min(window.latest, 1e6)], [window.earliest - t]]
        if np.isfinite(limits.jerk):
            jerk = jerk_of(ds, v)
            found += [jerk - limits.jerk, -jerk - limits.jerk]
        return np.concatenate(found)

    low = np.full(count, 1e-6)
    fixed = bound <= 0.0
    if not limits.closed:
        fixed[[0, -1]] = True
    low[fixed] = bound[fixed]
    bounds = [*zip(low, np.maximum(bound, low), strict=True), *([(0.0, limits.brake / 1e3)] * (count - 1) if braking else [])]
    rules = [{"type": "ineq", "fun": lambda x: -rows(x)}]
    if limits.closed:
        rules.append({"type": "eq", "fun": lambda x: x[:1] - x[count - 1 : count]})
    start = np.concatenate([np.clip(0.5 * v0**2 / scale, low, np.maximum(bound, low)), np.zeros(len(bounds) - count)])
    found = minimize(energy, start, method="SLSQP", bounds=bounds, constraints=rules, options={"maxiter": 150, "ftol": 1e-10})
    assert np.max(rows(found.x)) < 1e-5, found.message
    return float(found.fun) * unit, parts(found.x)[0]


@pytest.mark.parametrize(
    "name", [name if name in ("weak", "brakes", "stop", "circuit") else pytest.param(name, marks=pytest.mark.slow) for name in CASES]
)
@pytest.mark.filterwarnings("ignore:Values in x were outside bounds")
def test_solutions_are_those_of_scipy(name: str):
    case = CASES[name]
    limits = tiny(case.vehicle, case.extra, closed=case.closed, start=case.start, end=case.end)
    solver = EcoSolver(limits)
    allowed = case.factor * solver.least_time
    profile = solver.arriving(allowed)
    assert profile.status == "solved"
    ledger = drive_energy(limits.vehicle, limits.s, profile.v, limits.z, 0.0 if profile.brake is None else profile.brake)
    moved = sum(abs(part) for part in ledger.components.values())
    best, _ = reference(limits, allowed, fastest_profile(limits).v / case.factor)
    # SLSQP works with differences and keeps rows to 1e-5
    assert ledger.total <= best + 3e-5 * moved
    assert ledger.total >= best - 1e-3 * moved


def programme(limits: SpeedLimits, journey_time: float) -> ChainProgramme:
    model = IntervalModel(limits)
    bound = limits.energy_max / model.energy_scale
    fixed = bound <= 0.0
    fixed[[0, -1]] = True
    jerk = JerkModel(limits, model.energy_scale) if np.isfinite(limits.jerk) else None
    return ChainProgramme(model, bound, fixed, [Deadline(model.count, journey_time, 1)], jerk=jerk)


@pytest.mark.parametrize("kind", [*KINDS, "jerk"])
def test_the_solution_meets_the_optimality_conditions_by_our_own_sums(kind: str):
    limits = tiny(WEAK, KINDS.get(kind, (Jerk(1.0),)))
    allowed = 1.25 * EcoSolver(limits).least_time
    chain = programme(limits, allowed)
    found = chain.solve(chain.start(0.3 * fastest_profile(limits).v ** 2 / chain.model.energy_scale))
    assert found.solved
    at, model = found.iterate, chain.model
    unknown = np.column_stack([at.x[:-1], at.x[1:], at.local])
    price = float(at.price[0]) / allowed
    values, slopes = model.values(unknown), model.slopes(unknown, at.dual, np.full(model.count, price))
    # stationarity by x: central differences of the Lagrangian as one scalar function
    free = np.flatnonzero(chain.free)

    def lagrangian(x: np.ndarray, local: np.ndarray) -> float:
        v = model.values(np.column_stack([x[:-1], x[1:], local]))
        total = np.sum(v.energy) + price * np.sum(v.time) + np.sum(at.dual * v.rows) - at.low @ x + at.high @ x
        return float(total + (np.sum(at.jerk_dual * chain.jerk.values(x)) if chain.jerk else 0.0))

    for k in free:
        step = np.zeros_like(at.x)
        step[k] = 1e-6 * max(at.x[k], 1e-2)
        slope = (lagrangian(at.x + step, at.local) - lagrangian(at.x - step, at.local)) / (2 * step[k])
        assert slope == pytest.approx(0.0, abs=1e-5)
    own = slopes.energy + np.einsum("nk,nkj->nj", at.dual, slopes.rows)
    assert own[:, 2 : 2 + chain.locals] == pytest.approx(0.0, abs=1e-6)
    # feasible, multipliers not negative, complementary
    assert np.max(values.rows) < 1e-8
    assert np.sum(values.time) <= allowed * (1 + 1e-8)
    for dual, slack in ((at.dual, -values.rows), (at.low, at.x), (at.high[free], (chain.bound - at.x)[free])):
        assert np.all(dual >= 0.0)
        assert np.sum(np.abs(dual * slack)) < 1e-6 * np.sum(np.abs(values.energy))
    assert price * (allowed - np.sum(values.time)) < 1e-6


@pytest.mark.parametrize("kind", [*KINDS, "jerk"])
def test_the_solution_does_not_depend_on_the_start(kind: str, rng: np.random.Generator):
    limits = tiny(WEAK, KINDS.get(kind, (Jerk(1.0),)), count=12)
    allowed = 1.25 * EcoSolver(limits).least_time
    chain = programme(limits, allowed)
    top = fastest_profile(limits).v ** 2 / 2 / chain.model.energy_scale
    found = [chain.solve(chain.start(factor * top, price=price)) for factor, price in ((0.9, 1e-3), (0.5, 1.0), (0.2, 1e-2))]
    found += [chain.solve(chain.start(rng.uniform(0.1, 0.9, len(top)) * top)) for _ in range(4)]
    # sensible starts all lead there; from wild ones it may stall, and then says so
    assert all(one.solved for one in found[:3])
    assert sum(one.solved for one in found) >= 4
    profiles = [np.sqrt(2 * one.iterate.x * chain.model.energy_scale) for one in found if one.solved]
    for v in profiles[1:]:
        assert v == pytest.approx(profiles[0], abs=2e-2)
    energies = [drive_energy(WEAK, limits.s, v, limits.z, 0.0).total if limits.brake == 0.0 else 0.0 for v in profiles]
    assert energies == pytest.approx([energies[0]] * len(energies), rel=1e-5, abs=1.0)


def test_a_warm_start_and_a_cold_one_end_at_the_same_profile():
    limits = tiny(ROMO, count=12)
    solver = EcoSolver(limits)
    times = np.array([1.05, 1.1, 1.2, 1.4]) * solver.least_time
    warm = None
    for journey_time in times:
        profile, warm = solver.arriving_from(float(journey_time), warm)
        cold = eco_profile(limits, float(journey_time))
        assert profile.v == pytest.approx(cold.v, abs=5e-3)
        assert profile.price == pytest.approx(cold.price, rel=1e-2)


def test_the_price_is_what_a_second_less_costs():
    limits = tiny(ROMO, count=12)
    allowed, width = 1.2 * fastest_profile(limits).journey_time, 0.05
    costs = [drive_energy(ROMO, limits.s, eco_profile(limits, allowed + shift).v, limits.z).total for shift in (-width, width)]
    assert eco_profile(limits, allowed).price == pytest.approx((costs[0] - costs[1]) / (2 * width), rel=2e-2)


def test_a_time_and_the_price_found_for_it_give_the_same_profile():
    limits = tiny(ROMO, count=12)
    timed = eco_profile(limits, 1.2 * fastest_profile(limits).journey_time)
    priced = eco_profile(limits, price=timed.price)
    assert priced.v == pytest.approx(timed.v, abs=2e-2)
    assert priced.journey_time == pytest.approx(timed.journey_time, rel=1e-3)
