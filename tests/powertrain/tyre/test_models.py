"""What every tyre model has in common, and the physics of the linear and the magic tyre."""

import pickle

import casadi as ca
import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from powertrain import VehicleError
from powertrain.tyre import LinearTyre, MagicTyre, TyreForces, slip_power
from powertrain.tyre.force import load_share

from .conftest import BOOK, TYRES, linear_tyre, magic_tyre

EVERY = pytest.mark.parametrize("name", TYRES)
SYMMETRIC = pytest.mark.parametrize("name", ["linear", "magic"])
SLIPS, ANGLES, LOADS = st.floats(-3.0, 3.0), st.floats(-1.5, 1.5), st.floats(0.0, 12e3)


def symbolic(name: str) -> tuple[ca.Function, ca.Function]:
    """Forces of (kappa, alpha, load, camber, friction) and their Jacobian."""
    inputs = [ca.SX.sym(word) for word in ("kappa", "alpha", "load", "camber", "friction")]
    forces = ca.vertcat(*TYRES[name].forces(*inputs))
    return ca.Function("forces", inputs, [forces]), ca.Function("jacobian", inputs, [ca.jacobian(forces, ca.vertcat(*inputs))])


@EVERY
def test_numbers_arrays_and_symbols_give_the_same_forces(name: str, rng: np.random.Generator):
    function, _ = symbolic(name)
    low, high = [-0.4, -0.4, -500.0, -0.1, 0.2], [0.4, 0.4, 9e3, 0.1, 1.2]
    points = rng.uniform(low, high, (40, 5))
    batch = np.array(TYRES[name].forces(*points.T.reshape(5, 8, 5)))
    assert batch.shape == (3, 8, 5)
    for point, many in zip(points, batch.reshape(3, -1).T, strict=True):
        single = TYRES[name].forces(*map(float, point))
        assert np.allclose(np.asarray(function(*point)).ravel(), many, rtol=1e-11, atol=1e-9)
        assert np.allclose([float(value) for value in single], many, rtol=1e-11, atol=1e-9)


@EVERY
def test_inputs_broadcast(name: str):
    forces = TYRES[name].forces(np.linspace(-0.1, 0.1, 4)[:, None], np.linspace(-0.1, 0.1, 3), 3000.0)
    assert np.broadcast_shapes(*(np.shape(value) for value in forces)) == (4, 3)


@EVERY
@pytest.mark.parametrize("load", [0.0, -1.0, -5000.0])
def test_a_wheel_without_load_has_no_force(name: str, load: float):
    assert np.all(np.abs(TYRES[name].forces(0.2, -0.1, load, 0.02)) == 0.0)


@EVERY
@pytest.mark.parametrize("load", [-100.0, 0.0, 1e-3, 2500.0])
@pytest.mark.parametrize("friction", [0.0, 1.0])
def test_value_and_jacobian_are_finite_at_zero_slip(name: str, load: float, friction: float):
    function, jacobian = symbolic(name)
    for kappa, alpha in [(0.0, 0.0), (0.0, 0.05), (0.05, 0.0)]:
        assert np.all(np.isfinite(function(kappa, alpha, load, 0.0, friction).full()))
        assert np.all(np.isfinite(jacobian(kappa, alpha, load, 0.0, friction).full()))


@EVERY
@pytest.mark.parametrize("place", range(5))
def test_not_a_number_comes_out_as_such(name: str, place: int):
    """No limit inside a model may turn a lost measurement into a force that looks sound."""
    point = [0.05, 0.05, 3000.0, 0.02, 0.9]
    point[place] = np.nan
    assert np.any(np.isnan(np.array(TYRES[name].forces(*point), dtype=float)))


@SYMMETRIC
@pytest.mark.parametrize("load", [500.0, 2484.0, 6000.0])
def test_stiffness_is_the_derivative_at_zero_slip(name: str, load: float):
    _, jacobian = symbolic(name)
    slopes = jacobian(0.0, 0.0, load, 0.0, 1.0).full()
    assert slopes[0, 0] == pytest.approx(TYRES[name].slip_stiffness(load), rel=1e-9)
    assert slopes[1, 1] == pytest.approx(TYRES[name].cornering_stiffness(load), rel=1e-9)


@EVERY
def test_signs_are_those_of_the_package(name: str):
    """Positive slip drives, positive side slip pushes left and turns the wheel back, leaning right pushes right."""
    forces = TYRES[name].forces(0.0, 0.04, 3000.0)
    assert TYRES[name].forces(0.05, 0.0, 3000.0).longitudinal > 0.0
    assert forces.lateral > 0.0 > forces.aligning
    assert TYRES[name].forces(0.0, 0.0, 3000.0, 0.05).lateral < TYRES[name].forces(0.0, 0.0, 3000.0).lateral
    assert TYRES[name].cornering_stiffness(3000.0) > 0.0 < TYRES[name].slip_stiffness(3000.0)


@SYMMETRIC
@given(kappa=SLIPS, alpha=ANGLES, load=LOADS)
def test_left_and_right_driving_and_braking_are_mirror_images(name: str, kappa: float, alpha: float, load: float):
    tyre = TYRES[name]
    here, left, braking = tyre.forces(kappa, alpha, load, 0.03), tyre.forces(kappa, -alpha, load, -0.03), tyre.forces(-kappa, alpha, load, 0.03)
    assert left == (here.longitudinal, -here.lateral, -here.aligning)
    assert braking == (-here.longitudinal, here.lateral, here.aligning)


@pytest.mark.parametrize("name", ["mf61", "mf52"])
@given(kappa=st.floats(-0.3, 0.3), alpha=st.floats(-0.3, 0.3), load=st.floats(0.0, 8e3), camber=st.floats(-0.1, 0.1))
def test_the_mirrored_tyre_is_the_mirror_image(name: str, kappa: float, alpha: float, load: float, camber: float):
    tyre = msgspec.structs.replace(TYRES[name], side="left")
    here, there = tyre.on("left").forces(kappa, alpha, load, camber), tyre.on("right").forces(kappa, -alpha, load, -camber)
    assert there == (here.longitudinal, -here.lateral, -here.aligning)


@given(kappa=st.floats(-50.0, 50.0), alpha=ANGLES, load=LOADS, friction=st.floats(0.0, 1.5))
def test_magic_keeps_the_friction_ellipse(kappa: float, alpha: float, load: float, friction: float):
    tyre = TYRES["magic"]
    assert isinstance(tyre, MagicTyre)
    forces = tyre.forces(kappa, alpha, load, 0.02, friction)
    peak = load_share(load, tyre.nominal_load_n, tyre.load_degression) * max(friction, 1e-6)
    share = np.hypot(forces.longitudinal / tyre.longitudinal_peak_n, forces.lateral / tyre.peak_n)
    assert share <= peak * (1.0 + 1e-12)


@given(kappa=SLIPS, alpha=ANGLES, load=LOADS, friction=st.floats(0.0, 1.5), speed=st.floats(0.0, 60.0))
def test_sliding_loses_power_before_any_cut(kappa: float, alpha: float, load: float, friction: float, speed: float):
    for tyre in (linear_tyre(load_degression=0.3), magic_tyre(load_degression=0.3)):
        forces = tyre.forces(kappa, alpha, load, 0.0, friction)
        assert forces.longitudinal * kappa >= 0.0
        assert forces.lateral * np.tan(alpha) >= 0.0
        assert slip_power(forces, kappa, alpha, speed) == pytest.approx((forces.longitudinal * kappa + forces.lateral * np.tan(alpha)) * speed)


@EVERY
@given(kappa=st.floats(-0.5, 0.5), alpha=st.floats(-0.5, 0.5), load=LOADS, camber=st.floats(-0.1, 0.1))
def test_slip_power_is_never_negative(name: str, kappa: float, alpha: float, load: float, camber: float):
    assert slip_power(TYRES[name].forces(kappa, alpha, load, camber), kappa, alpha, 20.0) >= 0.0


def test_slip_power_closes_the_wheels_power_balance():
    """What the shaft brings beyond what pushes the car forward and sideways is lost: F_x R omega - F_x v_x - F_y v_y."""
    omega, radius, vx, vy = 70.0, 0.3, 20.0, -1.5
    kappa, alpha = (omega * radius - vx) / vx, -np.arctan2(vy, vx)
    forces = magic_tyre().forces(kappa, alpha, 2400.0)
    lost = forces.longitudinal * radius * omega - forces.longitudinal * vx - forces.lateral * vy
    assert slip_power(forces, kappa, alpha, vx) == pytest.approx(lost)


def test_magic_pure_slip_is_the_observers_formula():
    """(C.4) with table C.4 and erratum 34: an axle's D of 7247 N over two wheels."""
    alpha = np.linspace(-1.5, 1.5, 101)
    ba = 5.1088547 * alpha
    axle = 7247.0 * np.sin(2.0280 * np.arctan(ba - 0.8903703 * (ba - np.arctan(ba))))
    assert np.allclose(2.0 * magic_tyre().forces(0.0, alpha, 2484.0).lateral, axle, rtol=0.0, atol=1e-7)
    assert 2.0 * magic_tyre().cornering_stiffness(2484.0) == pytest.approx(75.1e3, rel=1e-3)


def test_magic_combined_slip_is_similar_to_pure_slip():
    """At equal length of the normalised slip the share of the friction ellipse is the same in every direction, and the force points along it."""
    tyre = magic_tyre(longitudinal_peak_n=3000.0)
    bx, by = 60e3 / (2.0280 * 3000.0), 5.1088547
    for x in (0.1, 0.7, 1.4, 4.0):
        turn = np.linspace(0.0, 2.0 * np.pi, 25)
        forces = tyre.forces(x * np.cos(turn) / bx, x * np.sin(turn) / by, 2484.0)
        share, across = forces.longitudinal / 3000.0, forces.lateral / 3623.5
        pure = float(tyre.forces(0.0, x / by, 2484.0).lateral) / 3623.5
        assert np.allclose(np.hypot(share, across), pure, rtol=1e-10)
        assert np.allclose(share * np.sin(turn), across * np.cos(turn), atol=1e-10)


def test_friction_scales_the_peak_of_magic_and_leaves_its_stiffness():
    tyre, alpha = magic_tyre(), np.linspace(0.0, 1.5, 4000)
    dry, wet = tyre.forces(0.0, alpha, 2484.0).lateral, tyre.forces(0.0, alpha, 2484.0, friction=0.4).lateral
    assert wet.max() == pytest.approx(0.4 * dry.max(), rel=1e-5)
    assert wet[1] / dry[1] == pytest.approx(1.0, rel=1e-4)
    assert alpha[wet.argmax()] == pytest.approx(0.4 * alpha[dry.argmax()], rel=2e-3)


def test_friction_scales_the_peaks_of_mf():
    alpha = np.linspace(-0.4, 0.4, 2001)
    dry, wet = BOOK.forces(0.0, alpha, 4000.0).lateral, BOOK.forces(0.0, alpha, 4000.0, friction=0.5).lateral
    assert np.ptp(wet) == pytest.approx(0.5 * np.ptp(dry), rel=1e-2)


def test_a_locked_wheel_slides_with_what_magic_has_broadside():
    tyre = magic_tyre()
    broadside = float(tyre.forces(0.0, 0.5 * np.pi, 2484.0).lateral)
    assert 0.6 < broadside / 3623.5 < 0.9
    for kappa in (-1.0, 5.0, 300.0):
        assert abs(float(tyre.forces(kappa, 0.0, 2484.0).longitudinal)) == pytest.approx(broadside, rel=2e-2 if kappa == -1.0 else 1e-9)


@pytest.mark.parametrize("degression", [0.0, 0.3, 2.0])
def test_load_share_rises_less_and_less_and_is_one_at_the_nominal_load(degression: float):
    loads = np.linspace(0.0, 20e3, 400)
    share = load_share(loads, 2500.0, degression)
    assert share[0] == 0.0
    assert load_share(2500.0, 2500.0, degression) == 1.0
    assert np.all(np.diff(share) > 0.0)
    assert np.all(np.diff(share, 2) <= 1e-12)


@EVERY
def test_relaxation_lengths_stay_positive_and_grow_with_load(name: str):
    x, y = TYRES[name].relaxation(np.array([-100.0, 0.0, 1000.0, 3000.0]))
    assert np.all(np.diff(x) >= 0.0)
    assert np.all(np.diff(y) >= 0.0)
    assert np.min([x, y]) > 0.01
    assert np.max([x, y]) < 1.5
    assert 0.2 < TYRES[name].rolling_radius < 0.4


@EVERY
def test_a_tyre_survives_pickling(name: str):
    assert pickle.loads(pickle.dumps(TYRES[name])) == TYRES[name]


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("nominal_load_n", 0.0),
        ("nominal_load_n", float("nan")),
        ("stiffness_factor", -1.0),
        ("shape_factor", 0.9),
        ("curvature_factor", 1.01),
        ("peak_n", float("inf")),
        ("load_degression", -0.1),
        ("rolling_radius_m", "0.3"),
        ("relaxation_lateral_m", True),
    ],
)
def test_a_value_out_of_range_is_refused_by_name_with_what_was_expected(key: str, value: float):
    with pytest.raises(VehicleError, match=rf"^MagicTyre\.{key} is .*, expected a number [<>]") as caught:
        magic_tyre(**{key: value})
    assert "\n" not in str(caught.value)


def test_a_curve_that_turns_the_force_round_is_refused():
    with pytest.raises(VehicleError, match="turn the side force round below a slip angle of 90 degrees"):
        magic_tyre(shape_factor=2.5, curvature_factor=-20.0, stiffness_factor=20.0)


def test_unknown_and_missing_keys_are_refused_when_decoding():
    table = msgspec.to_builtins(linear_tyre())
    assert msgspec.convert(table, LinearTyre) == linear_tyre()
    for wrong in (table | {"grip": 1.0}, {key: value for key, value in table.items() if key != "slip_stiffness_n"}):
        with pytest.raises(msgspec.ValidationError):
            msgspec.convert(wrong, LinearTyre)


@pytest.mark.parametrize(("name", "most"), [("linear", 30), ("magic", 60), ("mf61", 400), ("mf52", 440)])
def test_a_wheel_costs_few_instructions(name: str, most: int):
    """A budget, not a physical fact: the magic tyre runs 16 times in each millisecond of the plant."""
    assert symbolic(name)[0].n_instructions() < most


def test_forces_are_named():
    assert TyreForces._fields == ("longitudinal", "lateral", "aligning")
