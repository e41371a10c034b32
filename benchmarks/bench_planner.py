"""Many cars on one road: `Planner`, which finds the paths once, beside one call of `plan` for each, without and with the drives of the comparison."""

import msgspec

import energy_mgr
import roads
from energy_mgr import Planner, PlanRequest
from powertrain import load_vehicle

#: kg
MASSES = range(900, 1300, 50)
WAYS = ("reference", "path_only", "speed_only", "both")
METHODS = {"Planner, 8 cars": (True, False), "plan, 8 times": (False, False), "plan and its comparison, 8 times": (False, True)}


def pytest_generate_tests(metafunc):
    metafunc.parametrize("label", METHODS)


def cars():
    romo = load_vehicle("romo")
    return [msgspec.structs.replace(romo, chassis=msgspec.structs.replace(romo.chassis, mass_kg=float(mass))) for mass in MASSES]


def bench_cars_on_one_road(benchmark, label):
    shared, compared = METHODS[label]
    road, request = roads.open_road("commute"), PlanRequest(corridor="road")
    benchmark.group = "plans of 8 cars on `commute`"

    def run():
        planner = Planner(road)
        for car in cars():
            plan = planner.plan(car, request) if shared else energy_mgr.plan(road, car, request)
            if compared:
                for way in WAYS:
                    getattr(plan.comparison, way)
        return plan

    found = benchmark.pedantic(run, rounds=5, warmup_rounds=1)
    benchmark.extra_info.update(method=label, ours=shared, found=f"{found.energy_kwh:.4f} kWh")
