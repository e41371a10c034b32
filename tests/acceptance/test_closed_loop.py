"""E0 to E4 in closed loop, against the printed figures where they can be compared; see `closed_loop` and docs/results.md."""

import msgspec
import numpy as np
import pytest

from energy_mgr import Event, simulate

from . import closed_loop as e
from .documents import RESULTS, differences, figures, numbers, sentence, table

#: Distance that the plan keeps between the car's sides and the borders, m: an offset below it crosses none.
MARGIN = 0.2
ROADS = tuple(e.PRINTED)
#: How far documented figures may be off: another processor's last digits move a drive by that much. Torque rates add up every tremble, of which
#: last digits decide most: that of `preview` on `rural` was 3 % apart between two versions whose energies agree to all digits printed.
DRIVEN = {"digits": 2.0, "share": 5e-3}
TREMBLING = {"digits": 2.0, "share": 5e-2}


def wrong_rows(driven: str, key: str, figure) -> list[str]:
    """What docs/results.md says otherwise than a table that was driven, whose rows are recorded."""
    found, said = table(driven, key), figures(RESULTS, key)
    assert list(found) == list(said)
    for what, row in found.items():
        figure(f"{key}: {what}", "; ".join(f"{column} {cell}" for column, cell in row.items() if cell), "{}")
    return [
        f"{what}, {column}: {words}"
        for what, row in found.items()
        for column, cell in row.items()
        for words in differences(said[what][column], *numbers(cell), **(TREMBLING if "torque rate" in column else DRIVEN))
    ]


@pytest.mark.slow
@pytest.mark.parametrize("friction", [None, 0.3])
def test_e0_an_offset_of_two_metres_decays_without_overshoot(friction, figure):
    drive = e.offset_drive(friction=friction)
    events = [event for _, event in drive.happened]
    straight = simulate(drive.trajectory, e.romo(), events=events, longest=9.0, compiled=False)
    # bends leave an offset of their own (2 cm; 6 cm where nobody knows that it is slippery): what the start adds to it is what decays
    rest = drive["e_y_m"] - straight["e_y_m"]
    below = float(drive["t_s"][np.flatnonzero(np.abs(rest) >= 0.1)[-1]])
    figure(
        f"E0, friction {friction or 'of the road'}: below 0.1 m after, overshoot",
        (below, max(-float(rest.min()), 0.0)),
        "{:.2f} s, {:.4f} m",
        asked="1 %",
    )
    assert rest[0] == pytest.approx(2.0, abs=1e-6)
    assert np.all(np.abs(rest[drive["t_s"] > 3.0]) < 0.1)
    assert rest.min() > -0.02
    assert np.all(np.abs(drive["e_y_m"][drive["t_s"] > 4.0]) < 0.1)


@pytest.mark.slow
def test_e1_takes_the_printed_energy_but_for_what_the_tyres_lose():
    drives = {name: e.lane_change(name) for name in e.LANE_CHANGES}
    ours = drives["ours, physical"]
    assert ours.offset_rms < 0.05
    # 62.7 kJ, 4.8 % above the printed 59.9: what slides in the contact patches comes on top of the account that the wheels' inertia was chosen by
    assert ours.drive_energy - ours.ledger.energy["tyre"] == pytest.approx(59.88e3, rel=0.03)
    assert ours.drive_energy == pytest.approx(59.88e3, rel=0.06)
    published = [drives[f"published, {cost}"].drive_energy for cost in ("heuristic", "physical")]
    assert ours.drive_energy < min(published)
    # printed: 0.012 % apart, the physical cost being the lower one
    assert ours.drive_energy < drives["ours, heuristic"].drive_energy < 1.001 * ours.drive_energy


@pytest.mark.slow
def test_e1_takes_the_printed_energy_with_lighter_wheels(figure):
    # the source does not give their inertia: 0.65 kg m^2 is ours, 0.3 as possible
    chassis = msgspec.structs.replace(e.romo().chassis, wheel_inertia_kgm2=0.3)
    drive = simulate(e.double_lane_change(), msgspec.structs.replace(e.romo(), chassis=chassis), compiled=False)
    figure("E1 with wheels of 0.3 kg m^2", drive.drive_energy / 1e3, "{:.2f} kJ", published="59.88 kJ")
    assert drive.drive_energy == pytest.approx(59.88e3, rel=0.03)
    above = 100.0 * (drive.drive_energy / 59.88e3 - 1.0)
    said = figures(RESULTS, "closed loop")["E1 in closed loop"]["ours"].split(";")[1]
    assert not differences(said.split("with")[0], drive.drive_energy / 1e3, above, **DRIVEN)


@pytest.mark.slow
def test_e1_is_driven_as_documented(figure):
    driven = e.lane_change_table()
    assert not wrong_rows(driven, "E1", figure)
    energy = numbers(driven.splitlines()[0])[0]
    assert not differences(sentence(RESULTS, "quasi-static", "kJ, printed 59.88"), energy)


@pytest.mark.slow
@pytest.mark.parametrize("road", ROADS)
def test_roads_are_driven_as_documented(road, figure):
    assert not wrong_rows(e.table(road, preview=True), road, figure)


@pytest.mark.slow
def test_what_the_plans_leave_out_is_documented(figure):
    accounts = {road: e.Account.of(e.ours(road)) for road in ROADS}
    beyond, explained = ([a.drive - a.plan - k * a.tyre for a in accounts.values()] for k in (0.0, 1.0))
    shares = [[100.0 * value / abs(a.plan) for value, a in zip(values, accounts.values(), strict=True)] for values in (beyond, explained)]
    tyre = [a.tyre / e.KWH for a in accounts.values()]
    for road, value, kwh in zip(ROADS, beyond, tyre, strict=True):
        figure(f"{road}: drives over plan, of it tyre slip", (value / e.KWH, kwh), "{:.4f} kWh, {:.4f} kWh", asked="3 %")
    row = figures(RESULTS, "closed loop")["closed loop against plan"]
    ours = [*shares[0][:2], beyond[2] / e.KWH, *map(abs, shares[1])]
    assert not differences(row["ours"], *ours, **DRIVEN)
    assert not differences(row["why"], *tyre, **DRIVEN)


@pytest.mark.slow
@pytest.mark.parametrize("road", ROADS)
def test_published_methods_show_the_published_trend(road):
    base, physical = e.published(road, "reference", "heuristic"), e.published(road, "reference", "physical")
    path, path_physical = e.published(road, "path_only", "heuristic"), e.published(road, "path_only", "physical")
    for drive in (base, physical, path, path_physical):
        assert drive.outcome == "arrived"
        assert drive.journey_time == pytest.approx(base.journey_time, rel=3e-3)
    # the optimised path saves, the physical cost does not pay
    assert path.battery_energy < base.battery_energy
    assert physical.battery_energy > base.battery_energy
    assert path_physical.battery_energy > path.battery_energy


@pytest.mark.slow
@pytest.mark.parametrize("road", ROADS)
def test_ours_saves_more_than_printed_at_equal_time_and_follows_within_the_margin(road):
    base, ours = e.published(road, "reference", "heuristic"), e.ours(road)
    assert ours.outcome == "arrived"
    assert ours.journey_time == pytest.approx(base.journey_time, rel=1e-3)
    printed_kwh, printed_percent = e.PRINTED[road][1]
    saved = ours.battery_energy - base.battery_energy
    assert saved < printed_kwh * e.KWH
    if base.battery_energy > 0.0:
        assert 100.0 * saved / base.battery_energy < printed_percent
    assert ours.offset_rms < 0.2
    assert ours.offset_max < MARGIN


@pytest.mark.slow
@pytest.mark.parametrize("road", ROADS)
def test_the_physical_cost_is_no_worse_than_the_heuristic_with_our_allocator(road):
    # a tenth of a thousandth: where both find the same split, which is the rule on straight roads
    assert e.ours(road).battery_energy <= e.ours(road, cost="heuristic").battery_energy + 1e-4 * abs(e.ours(road).battery_energy)


@pytest.mark.slow
@pytest.mark.parametrize("road", ROADS)
def test_closed_loop_energy_is_the_plans_but_for_tyre_slip_within_three_per_cent(road):
    account = e.Account.of(e.ours(road))
    # of what flows, since on `descent` the sum is near zero
    moved = max(abs(account.plan), e.ours(road).ledger.energy["drag"] + e.ours(road).ledger.energy["rolling"])
    assert abs(account.drive - account.tyre - account.plan) < 0.03 * moved
    assert 0.0 < account.tyre < 0.15 * moved


@pytest.mark.slow
def test_torques_jitter_five_times_less_than_with_the_published_methods():
    ours = e.ours("commute").torque_jitter
    assert 5.0 * ours < e.published("commute", "path_only", "heuristic").torque_jitter
    assert 5.0 * ours < e.published("commute", "path_only", "physical").torque_jitter


FAULTS = [
    *((f"motor_{k + 1}", "dead") for k in range(4)),
    *((f"brake_{wheel}", "dead") for wheel in ("fl", "fr", "rl", "rr")),
    *((f"steer_{wheel}", "stuck") for wheel in ("fl", "fr", "rl", "rr")),
]


@pytest.mark.slow
@pytest.mark.parametrize(("part", "kind"), FAULTS)
def test_with_every_single_fault_from_a_bend_of_commute_on_the_car_stays_on_the_road_and_arrives(part, kind, figure):
    lam = e.plans("commute")["both"]
    sharpest = float(lam.s[np.argmax(np.abs(lam.kappa) * lam.v**2 * (lam.v > 8.0))])
    drive = simulate(lam, e.romo(), events=[Event(part=part, kind=kind, station_m=sharpest)])
    figure(f"commute, {part} {kind}: largest offset", drive.offset_max, "{:.3f} m", asked=f"{MARGIN} m")
    assert drive.happened
    assert drive.errors == 0
    assert drive.outcome == "arrived"
    # a dead motor or brake costs no time; with a stuck wheel the car drives at 0.6 of the planned speed
    slower = lam.journey_time / 0.6 if kind == "stuck" else lam.journey_time
    assert 0.99 * lam.journey_time < drive.journey_time < 1.01 * slower
    assert drive.offset_max < MARGIN
    named = {"motor": "motor", "brake": "brake", "steer": "steering"}[part.split("_")[0]]
    assert any(named in said for _, said in drive.noticed)
