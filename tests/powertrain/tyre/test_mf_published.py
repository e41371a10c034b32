"""MF-Tyre against numbers of independent packages; each table says in its head where it comes from."""

import casadi as ca
import msgspec
import numpy as np
import pytest

from powertrain.tyre import MfTyre
from powertrain.tyre.mf import v52, v61
from powertrain.tyre.mf.curve import cosine, length, sine
from powertrain.tyre.mf.shared import State, kappa_induced, lateral_weight, longitudinal_factors, longitudinal_weight

from .conftest import BOOK, SAMPLE, table

#: The tables have ten digits, so 1e-9 of the value; near zero crossings that many digits of the terms that cancel there.
RELATIVE = 1e-6
FORCE_FLOOR, MOMENT_FLOOR = 1e-3, 1e-5

#: Coefficients that put every term of 6.1 to work which the book's tyre leaves at zero.
EXTRA = {
    **{"PPX1": -0.31, "PPX2": 0.27, "PPX3": -0.09, "PPX4": 0.14, "PPY1": 0.41, "PPY2": 0.73, "PPY3": -0.13, "PPY4": 0.11, "PPY5": 0.22},
    **{"PDX3": 1.7, "PEX4": 0.06, "PVX1": 0.004, "PVX2": -0.002, "RBX3": 3.1, "REX1": 0.21, "REX2": -0.13, "PEY5": 4.2, "PKY4": 1.9},
    **{"PKY5": 2.7, "RBY4": 5.3, "REY1": 0.17, "REY2": -0.08, "RHY2": -0.004, "PKY3": 0.6, "PDY3": 2.2, "LMUX": 0.95, "LMUY": 0.97},
    **{"LKYC": 1.1, "LKX": 1.03, "LKY": 1.04, "LCX": 1.02, "LCY": 0.98, "LEX": 0.9, "LEY": 1.1, "LHX": 0.8, "LHY": 0.7, "LVX": 1.2},
    **{"LVY": 1.3, "LXAL": 0.9, "LYKA": 1.1, "LVYKA": 1.2, "LFZO": 1.05, "QBZ4": 0.33, "QDZ10": 0.4, "QDZ11": -0.3, "PPZ1": -0.4},
    **{"PPZ2": -0.6, "QEZ3": -0.1, "QBZ10": 0.1, "QDZ7": 0.003, "LTR": 1.1, "LRES": 0.9, "LKZC": 1.2, "LS": 1.1},
}


def off(found, expected, floor: float) -> float:
    """The largest difference, of the value or, near zero crossings, of a thousand floors."""
    return float(np.max(np.abs(found - expected) / np.maximum(np.abs(expected), floor / 1e-3)))


def close(found, expected, floor: float) -> bool:
    return off(found, expected, floor) <= RELATIVE


def as_octave_package(kappa: float, alpha: float, camber: float, load: float) -> tuple[float, float, float]:
    """Our factors put together as that package does where it leaves the book: it takes the angle and not its tangent into the lateral curve,
    the shifts of the residual moment at zero camber and cos(alpha) twice in it, and the moment arm of F_x without camber, at zero slip not at all.
    """
    p = BOOK.coefficients
    state = State(kappa, alpha, np.tan(alpha), load, camber, np.sin(camber))
    plain = state._replace(slip=alpha)
    upright = plain._replace(camber=0.0, lean=0.0)
    x, y, y0 = longitudinal_factors(p, state), v61.lateral_factors(p, plain), v61.lateral_factors(p, upright)
    longitudinal = longitudinal_weight(p, state) * (sine(x, kappa + x.horizontal) + x.vertical)
    reduction = lateral_weight(p, state)
    lateral = reduction * (sine(y, alpha + y.horizontal) + y.vertical) + kappa_induced(p, state, y.friction)
    trail, residual, other = v61.trail_factors(p, state), v61.residual_factors(p, state, y0), x.slope / y.slope * kappa
    lever = cosine(trail, length(state.slip + trail.horizontal, other)) * np.cos(alpha)
    remains = cosine(residual, length(state.slip + residual.horizontal, other)) * np.cos(alpha)
    arm = p.UNLOADED_RADIUS * (p.SSZ1 + p.SSZ2 * lateral / p.FNOMIN) * (kappa != 0.0)
    steering = reduction * (sine(y0, alpha + y0.horizontal) + y0.vertical)
    return longitudinal, lateral, remains - lever * steering + arm * longitudinal


def test_longitudinal_force_of_61_is_that_of_the_octave_package_pure_and_combined_with_camber(figure):
    rows = table("mf61_octave.csv")
    found = BOOK.forces(rows[:, 0], -rows[:, 1], rows[:, 3], rows[:, 2]).longitudinal
    figure("MF-Tyre 6.1, F_x off the published values", off(found, rows[:, 4], FORCE_FLOOR), "{:.1e}", asked="1e-6")
    assert len(rows) == 59
    assert close(found, rows[:, 4], FORCE_FLOOR)


def test_pure_lateral_force_of_61_is_that_of_the_octave_package_at_the_angle_whose_tangent_is_its_angle():
    rows = table("mf61_octave.csv")
    rows = rows[(rows[:, 0] == 0.0) & (rows[:, 1] != 0.0)]
    found = BOOK.forces(0.0, -np.arctan(rows[:, 1]), rows[:, 3], rows[:, 2]).lateral
    assert close(found, rows[:, 5], FORCE_FLOOR)


def test_every_factor_of_61_gives_the_octave_packages_combined_forces_and_moments_when_put_together_its_way(figure):
    rows = table("mf61_octave.csv")
    rows = rows[np.isfinite(rows[:, 5])]
    found = np.array([as_octave_package(*row[:4]) for row in rows])
    for column, (name, floor) in enumerate({"F_x": FORCE_FLOOR, "F_y": FORCE_FLOOR, "M_z": MOMENT_FLOOR}.items()):
        worst = off(found[:, column], rows[:, 4 + column], floor)
        assert figure(f"MF-Tyre 6.1, {name} off the published values, put together that package's way", worst, "{:.1e}", asked="1e-6") <= RELATIVE


def test_61_with_pressure_scaling_and_all_camber_terms_is_the_julia_package_put_back_to_the_book():
    """Put back are: sin(camber) for camber in B_t, D_t and s; |camber| in QDZ3; LFZO F_z0 for F_z0 in s; no LFZO on the trail;
    cos(alpha) for cos(tan(alpha)) in D_r; equivalent slips without tangents (seven places, all in the aligning moment).
    """
    tyre = msgspec.structs.replace(BOOK, coefficients=msgspec.structs.replace(BOOK.coefficients, **EXTRA))
    rows = table("mf61_mfeval.csv")
    found = tyre.forces(rows[:, 0], -rows[:, 1], rows[:, 3], rows[:, 2], pressure=rows[:, 4])
    assert close(found.longitudinal, rows[:, 5], FORCE_FLOOR)
    assert close(found.lateral, rows[:, 6], FORCE_FLOOR)
    assert close(found.aligning, rows[:, 7], MOMENT_FLOOR)


def test_52_is_the_mfpy_package(monkeypatch: pytest.MonkeyPatch, figure):
    """That package takes the book's equivalent slips; the manual's, which have tangents, are checked against their closed form below."""
    monkeypatch.setattr(v52, "equivalent", length)
    rows = table("mf52_mfpy.csv")
    found = SAMPLE.forces(rows[:, 0], -rows[:, 1], rows[:, 3], rows[:, 2])
    floors = (FORCE_FLOOR, FORCE_FLOOR, MOMENT_FLOOR)
    worst = max(off(ours, rows[:, 4 + k], floor) for k, (ours, floor) in enumerate(zip(found, floors, strict=True)))
    assert figure("MF-Tyre 5.2, forces and moment off the other transcription", worst, "{:.1e}", asked="1e-6") <= RELATIVE


def test_equivalent_slip_of_the_52_manual_is_the_angle_alone_and_the_slip_alone():
    assert v52.equivalent(0.3, 0.0) == pytest.approx(0.3, rel=1e-12)
    assert v52.equivalent(0.0, 0.4) == pytest.approx(np.arctan(0.4), rel=1e-12)
    assert np.tan(v52.equivalent(-0.3, 0.4)) ** 2 == pytest.approx(np.tan(0.3) ** 2 + 0.16, rel=1e-12)


def _commonroad_tyre() -> tuple[MfTyre, object]:
    """The tyre of the CommonRoad vehicle models, which is 5.2 at the nominal load with a cornering stiffness in proportion to load."""
    parameters = pytest.importorskip("vehiclemodels.parameters_vehicle2").parameters_vehicle2().tire
    parameters.p_vx1 = 0.0  # stands inside the sine there
    names = {name.upper().replace("_", "", 1): value for name, value in vars(parameters).items()}
    known = {key.replace("_", ""): value for key, value in names.items()}
    coefficients = msgspec.structs.replace(
        SAMPLE.coefficients, **dict.fromkeys((k for k in SAMPLE.coefficients.__struct_fields__ if k[0] in "PQRST" and k[-1].isdigit()), 0.0)
    )
    coefficients = msgspec.structs.replace(coefficients, FNOMIN=4000.0, LMUX=1.0, LMUY=1.0, LKY=1.0, PKY2=1.0, **known)
    return MfTyre(name="CommonRoad", version="5.2", coefficients=coefficients), parameters


@pytest.mark.parametrize("kappa", [-0.2, -0.03, 0.01, 0.15])
@pytest.mark.parametrize("alpha", [-0.15, -0.02, 0.08])
@pytest.mark.parametrize("camber", [0.02, 0.09])
def test_52_is_the_commonroad_vehicle_models_at_the_nominal_load(kappa: float, alpha: float, camber: float):
    tyre, p = _commonroad_tyre()
    peer = pytest.importorskip("vehiclemodels.utils.tire_model")
    pure, friction = peer.formula_lateral(alpha, camber, 4000.0, p)
    found = tyre.forces(kappa, -alpha, 4000.0, camber)
    assert found.longitudinal == pytest.approx(peer.formula_longitudinal_comb(kappa, alpha, peer.formula_longitudinal(-kappa, camber, 4000.0, p), p))
    assert found.lateral == pytest.approx(peer.formula_lateral_comb(kappa, alpha, camber, friction, 4000.0, pure, p), rel=1e-6)


@pytest.mark.parametrize("tyre", [BOOK, SAMPLE], ids=["6.1", "5.2"])
def test_derivative_at_the_shifts_is_the_stiffness(tyre: MfTyre):
    """B C D is the slope where the shifted slip is zero, by the definition of the magic formula."""
    p, state = tyre.coefficients, tyre._state(0.0, 0.0, 4100.0)
    x = longitudinal_factors(p, state)
    slip = ca.SX.sym("slip")
    slope = ca.Function("slope", [slip], [ca.jacobian(sine(x, slip), slip)])
    assert float(slope(1e-9)) == pytest.approx(tyre.slip_stiffness(4100.0), rel=1e-6)
    y = (v61 if tyre.version == "6.1" else v52).lateral_factors(p, state)
    slope = ca.Function("slope", [slip], [ca.jacobian(sine(y, slip), slip)])
    assert -float(slope(1e-9)) == pytest.approx(tyre.cornering_stiffness(4100.0), rel=1e-6)


def test_pure_slip_is_the_closed_form_magic_formula():
    """Written out for the book's tyre at its nominal load, where every load increment is zero; its combined weight at zero side slip is 1."""
    kappa = np.linspace(-0.3, 0.3, 31)
    shifted, peak = kappa - 0.002, 1.210 * 4000.0
    b = 21.51 * 4000.0 / (1.685 * peak)
    closed = peak * np.sin(1.685 * np.arctan(b * shifted - 0.344 * (b * shifted - np.arctan(b * shifted))))
    assert np.allclose(BOOK.forces(kappa, 0.0, 4000.0).longitudinal, closed, rtol=1e-12)


def test_relaxation_lengths_of_52_and_61_are_their_closed_forms():
    assert SAMPLE.relaxation(4500.0)[0] == pytest.approx(2.1 * 0.32)
    assert SAMPLE.relaxation(4500.0)[1] == pytest.approx(2.3 * np.sin(2.0 * np.arctan(1.0 / 1.9)) * 0.32)
    x, y = BOOK.relaxation(4000.0)
    assert (x, y) == (pytest.approx(86040.0 / 474500.0), pytest.approx(BOOK.cornering_stiffness(4000.0) / 141800.0))
    assert 0.1 < x < y < 0.8


def test_rolling_radius_lies_between_the_loaded_and_the_unloaded_one_and_rolling_moment_is_the_octave_packages():
    assert 0.313 - 4000.0 / 196400.0 < BOOK.rolling_radius < 0.313
    assert BOOK.rolling_moment(-123.0, 4000.0, 16.67) == pytest.approx(12.52)
    assert BOOK.rolling_moment(0.0, 4000.0, -16.67) == pytest.approx(-12.52)


def with_coefficients(tyre: MfTyre, **changed: float) -> MfTyre:
    return msgspec.structs.replace(tyre, coefficients=msgspec.structs.replace(tyre.coefficients, **changed))


@pytest.mark.parametrize("tyre", [BOOK, SAMPLE], ids=["6.1", "5.2"])
def test_friction_is_the_scaling_factors_of_friction(tyre: MfTyre):
    slippery = with_coefficients(tyre, LMUX=0.6 * tyre.coefficients.LMUX, LMUY=0.6 * tyre.coefficients.LMUY)
    point = (0.06, -0.09, 3500.0, 0.04)
    assert tyre.forces(*point, 0.6) == pytest.approx(slippery.forces(*point), rel=1e-12)


def test_52_knows_both_names_of_the_scaling_factor_of_camber():
    point = (0.02, 0.05, 3500.0, 0.06)
    found = [with_coefficients(SAMPLE, **{key: 1.3}).forces(*point) for key in ("LKYG", "LKYC")]
    assert found[0] == found[1] != SAMPLE.forces(*point)


def test_rolling_moment_is_the_closed_form_of_the_book():
    """(4.E70) with numbers in every coefficient, at 1.25 times the nominal load, 1.2 times the speed and 1.1 times the pressure."""
    tyre = with_coefficients(BOOK, QSY1=0.01, QSY2=0.3, QSY3=0.002, QSY4=0.001, QSY5=2.0, QSY6=-0.7, QSY7=0.9, QSY8=-0.4, INFLPRES=242000.0, LMY=1.1)
    share = 0.01 + 0.3 * (-400.0) / 4000.0 + 0.002 * 1.2 + 0.001 * 1.2**4 + 2.0 * 0.05**2 - 0.7 * 0.05**2 * 1.25
    closed = 5000.0 * 0.313 * share * 1.25**0.9 * 1.1**-0.4 * 1.1
    assert tyre.rolling_moment(-400.0, 5000.0, 1.2 * 16.67, 0.05) == pytest.approx(closed)
    assert tyre.rolling_moment(0.0, 0.0, 10.0) == 0.0


def test_carcass_stiffness_and_with_it_relaxation_follow_load_and_pressure():
    """Besselink, Schmeitz and Pacejka (17) to (19) at 1.25 times the nominal load and 1.1 times the pressure."""
    names = {"PCFX1": 0.2, "PCFX2": -0.3, "PCFX3": 0.4, "PCFY1": 0.15, "PCFY2": -0.25, "PCFY3": 0.35}
    tyre = with_coefficients(BOOK, INFLPRES=242000.0, **names)
    along = 474500.0 * (1.0 + 0.2 * 0.25 - 0.3 * 0.25**2) * (1.0 + 0.4 * 0.1)
    across = 141800.0 * (1.0 + 0.15 * 0.25 - 0.25 * 0.25**2) * (1.0 + 0.35 * 0.1)
    x, y = tyre.relaxation(5000.0)
    assert x == pytest.approx(tyre.slip_stiffness(5000.0) / along)
    assert y == pytest.approx(tyre.cornering_stiffness(5000.0) / across)


def test_relaxation_of_52_follows_the_load_with_a_falling_exponential():
    """Sign of PTX3 as in the MF-Tyre 5.2 manual; at 1.2 times the nominal load."""
    x, y = SAMPLE.relaxation(5400.0)
    assert x == pytest.approx(1.2 * (2.1 + 0.3 * 0.2) * np.exp(-0.2 * 0.2) * 0.32)
    assert y == pytest.approx(2.3 * np.sin(2.0 * np.arctan(1.2 / 1.9)) * 0.32)


@pytest.mark.parametrize("tyre", [BOOK, SAMPLE], ids=["6.1", "5.2"])
def test_curvature_above_one_is_cut_to_one(tyre: MfTyre):
    """The books' condition on E: a larger one would turn the curve back."""
    keys = {"PEX1": 1.0, "PEX2": 0.0, "PEX3": 0.0, "PEX4": 0.0}
    at_most, above = with_coefficients(tyre, **keys), with_coefficients(tyre, **(keys | {"PEX1": 7.0}))
    assert above.forces(0.2, 0.05, 3000.0) == at_most.forces(0.2, 0.05, 3000.0)
