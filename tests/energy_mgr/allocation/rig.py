"""Random situations, and a car written a second time in plain Python: wheel loads, forces, motion, losses, and what actuators may do next."""

import math
from types import SimpleNamespace

import numpy as np

from energy_mgr.allocation import Ahead, Allocator, Faults, Layout, Situation
from energy_mgr.motion import MotionDemand, VehicleState
from powertrain import Vehicle
from powertrain.energy.motor import motor_losses

DT = 0.004
G = 9.81
#: Least speed of slip angles (m/s) and least share of a wheel's load at rest, as `energy_mgr.allocation.effectiveness` states them.
SLOWEST, LIGHTEST = 1.0, 0.02


class Car:
    """Geometry and tyres of a vehicle, and the planar physics of (3.34) to (3.38)."""

    def __init__(self, vehicle: Vehicle, tyre="own") -> None:
        self.vehicle, self.layout = vehicle, Layout(vehicle)
        body, chassis = vehicle.body, vehicle.chassis
        self.mass, self.radius, self.body = chassis.mass_kg, chassis.wheel_radius_m, body
        self.X = (body.front_axle_m, body.front_axle_m, -body.rear_axle_m, -body.rear_axle_m)
        self.Y = (body.front_track_m / 2, -body.front_track_m / 2, body.rear_track_m / 2, -body.rear_track_m / 2)
        front, rear = vehicle.tyres()
        self.tyres, self.kind = (front, front, rear, rear), tyre
        drive = vehicle.drive
        self.motor_of_wheel = drive.motor_of_wheel
        self.share = drive.gear_ratio if drive.motor_count == sum(m is not None for m in self.motor_of_wheel) else drive.gear_ratio / 2

        #: commands of which a rack is one, to all commands
        columns = np.eye(self.layout.size)
        if not vehicle.steering.individual:
            for k in range(self.layout.steers.start, self.layout.size, 2):
                columns[k + 1, k] = 1.0
            columns = np.delete(columns, range(self.layout.steers.start + 1, self.layout.size, 2), axis=1)
        self.alike = columns

    def loads(self, a_x, a_y):
        b, m = self.body, self.mass
        base = b.front_axle_m + b.rear_axle_m
        found = []
        for k in range(4):
            ahead, left = self.X[k] > 0, self.Y[k] > 0
            rest = 0.5 * m * G * (b.rear_axle_m if ahead else b.front_axle_m) / base
            pitch = m * a_x * b.cog_height_m / base / 2 * (-1 if ahead else 1)
            share, track = (b.roll_front_share, b.front_track_m) if ahead else (1 - b.roll_front_share, b.rear_track_m)
            found.append(max(rest + pitch + share * m * a_y * b.cog_height_m / track * (-1 if left else 1), LIGHTEST * rest))
        return found

    def wheels(self, u, state):
        """along, side (N), delta, alpha, load, speed over ground and spin of each wheel."""
        v_x, v_y, yaw, a_x, a_y, friction = state
        layout, found = self.layout, []
        for k, load in enumerate(self.loads(a_x, a_y)):
            vx, vy = v_x - yaw * self.Y[k], v_y + yaw * self.X[k]
            delta = u[layout.steers][layout.steered.index(k)] if k in layout.steered else 0.0
            alpha = delta - math.atan2(vy, max(vx, SLOWEST))
            motor = self.motor_of_wheel[k]
            drive = 0.0 if motor is None else self.share * u[motor]
            along = (drive - u[layout.brakes][k]) / self.radius
            side = self._side(k, alpha, along, load, friction)
            found.append((along, side, delta, alpha, load, math.hypot(vx, vy), vx / self.radius))
        return found

    def _side(self, k, alpha, along, load, friction):
        tyre = self.tyres[k]
        if self.kind == "linear":
            return float(tyre.cornering_stiffness(self.loads(0.0, 0.0)[k])) * alpha
        return float(tyre.forces(along / tyre.slip_stiffness(load), alpha, load, friction=friction).lateral)

    def motion(self, u, state):
        total = np.zeros(3)
        for k, (along, side, delta, *_) in enumerate(self.wheels(u, state)):
            fx, fy = along * math.cos(delta) - side * math.sin(delta), along * math.sin(delta) + side * math.cos(delta)
            total += (fx / self.mass, fy / self.mass, (self.X[k] * fy - self.Y[k] * fx) / self.body.yaw_inertia_kgm2)
        return total

    def jacobian(self, u, state, of=None):
        """Central differences of `of` (by default the motion) over the commands."""
        of = of or self.motion
        columns = []
        for k, scale in enumerate(self.layout.scale):
            h = 1e-5 * scale
            up, down = u.copy(), u.copy()
            up[k], down[k] = up[k] + h, down[k] - h
            columns.append((np.asarray(of(up, state)) - of(down, state)) / (2 * h))
        return np.array(columns).T

    def usage(self, u, state):
        """(4, 8) forces of the wheels over their loads in eight directions: what the friction polygon bounds."""
        rows = []
        for along, side, _, _, load, *_ in self.wheels(u, state):
            rows.append([(math.cos(a) * along + math.sin(a) * side) / load for a in 2 * np.pi * np.arange(8) / 8])
        return np.array(rows)

    def spins(self, state):
        return [wheel[-1] for wheel in self.wheels(np.zeros(self.layout.size), state)]

    def motor_speeds(self, spins):
        return [sum(self.share * spins[w] for w in range(4) if self.motor_of_wheel[w] == m) for m in range(self.layout.motors)]

    def power(self, u, state):
        """Electrical power of the motors, W."""
        speeds = self.motor_speeds(self.spins(state))
        return sum(float(u[k]) * w + float(sum(motor_losses(self.vehicle, float(u[k]), w))) for k, w in enumerate(speeds))

    def losses(self, u, state):
        """Lost in motors, gears and inverters, friction brakes, and in the tyres' sliding, W."""
        total = 0.0
        for k, w in enumerate(self.motor_speeds(self.spins(state))):
            total += float(sum(motor_losses(self.vehicle, float(u[k]), w)))
        for k, (along, side, _, alpha, load, speed, spin) in enumerate(self.wheels(u, state)):
            total += u[self.layout.brakes][k] * abs(spin)
            total += (along**2 / float(self.tyres[k].slip_stiffness(load)) + side * math.tan(alpha)) * speed
        return total

    def range(self, speed):
        """Largest torque of a motor forwards and backwards."""
        d = self.vehicle.drive
        turning = max(abs(speed), 1e-9)
        drive, regen = min(d.torque_max_nm, d.power_max_w / turning), min(d.regen_torque_max_nm, d.regen_power_max_w / turning)
        ahead, back = min(max(1 + speed, 0.0), 1.0), min(max(1 - speed, 0.0), 1.0)
        return regen + (drive - regen) * ahead, regen + (drive - regen) * back

    def box(self, before, spins, faults, dt=DT):
        """What the actuators may be told next."""
        v = self.vehicle
        motors, brakes = faults.motors or (1.0,) * self.layout.motors, faults.brakes or (1.0,) * 4
        bounds, rates = [], []
        for share, speed in zip(motors, self.motor_speeds(spins), strict=True):
            forward, backward = self.range(speed)
            bounds.append((-backward * share, forward * share))
            rates.append(v.drive.torque_rate_nmps)
        for k, share in enumerate(brakes):
            most = v.brakes.front_torque_max_nm if k < 2 else v.brakes.rear_torque_max_nm
            bounds.append((0.0, most * share))
            rates.append(most / v.brakes.lag_s)
        for _ in self.layout.steered:
            bounds.append((-v.steering.angle_max_rad, v.steering.angle_max_rad))
            rates.append(v.steering.rate_max_radps)
        low, high = [], []
        for (least, most), rate, now in zip(bounds, rates, before, strict=True):
            low.append(min(max(least, now - rate * dt), most))
            high.append(max(min(most, now + rate * dt), least))
        for k, angle in enumerate(faults.stuck):
            if angle is not None:
                low[self.layout.steers.start + k] = high[self.layout.steers.start + k] = angle
        return np.array(low), np.array(high)


def random_faults(rng, layout: Layout) -> Faults:
    motors = brakes = stuck = ()
    if rng.random() < 0.5:
        motors = tuple(float(x) for x in rng.choice([0.0, 0.3, 1.0, 1.0], layout.motors))
    if rng.random() < 0.4:
        brakes = tuple(float(x) for x in rng.choice([0.0, 0.5, 1.0, 1.0], 4))
    if rng.random() < 0.4:
        stuck = tuple(float(rng.uniform(-0.1, 0.1)) if rng.random() < 0.35 else None for _ in layout.steered)
        if layout.racks:
            stuck = (stuck[0],) * len(stuck)
    return Faults(motors, brakes, stuck)


def random_state(rng, friction=None) -> VehicleState:
    v = 28.0 * rng.random() ** 1.5
    yaw = rng.uniform(-1, 1) * min(1.0, 6.0 / max(v, 1.0))
    mu = float(rng.choice([rng.uniform(0.1, 1.0), 1.0])) if friction is None else friction
    return VehicleState(0.0, 0.0, 0.0, v, v * rng.uniform(-0.08, 0.08), yaw, rng.uniform(-4, 4), rng.uniform(-5, 5), mu)


def random_window(rng):
    kind = rng.integers(4)
    if kind == 0:
        return -math.inf, math.inf
    if kind == 1:
        return -float(rng.uniform(0, 30e3)), float(rng.uniform(0, 60e3))
    if kind == 2:  # nothing to be taken
        return 0.0, float(rng.uniform(0, 5e3))
    return -float(rng.uniform(5e3, 60e3)), -float(rng.uniform(0, 4e3))  # the battery wants to be charged, whatever is asked


def random_situation(rng, car: Car, **more) -> Situation:
    layout = car.layout
    state = random_state(rng)
    spins = [s * rng.uniform(0.97, 1.03) for s in car.spins(state[3:])]
    faults = random_faults(rng, layout)
    # actuators may have failed only now
    low, high = car.box(np.zeros(layout.size), spins, faults if rng.random() < 0.5 else Faults(), dt=1e3)
    before = low + rng.beta(0.7, 0.7, layout.size) * (high - low)
    before[layout.steers] *= rng.choice([0.1, 0.5, 1.0])
    before[layout.brakes] *= rng.choice([0.0, 0.0, 1.0])
    for left, right in layout.racks:
        before[right] = before[left]
    low, high = random_window(rng)
    demand = rng.uniform(-1, 1, 3) * rng.choice([1.0, 4.0, 10.0])
    now = Situation(state, MotionDemand(*demand.tolist()), before, spins, faults, low, high, DT)
    if rng.random() < 0.4:  # near what is given already
        calm = np.zeros(3)
        now.before[layout.steers] *= 0.2
        for _ in range(30):
            calm += 0.3 * (car.motion(before, led(car, now._replace(demand=MotionDemand(*calm.tolist())))) - calm)
        now = now._replace(demand=MotionDemand(*np.clip(calm + rng.normal(0, 0.01, 3), -30, 30).tolist()))
    return now._replace(**more)


def led(car: Car, now: Situation, lead=None):
    """The state when the steering will have turned: v_x, v_y, yaw rate, a_x, a_y, friction."""
    lead = car.vehicle.steering.lag_s if lead is None else lead
    v_x, v_y, yaw, a_x, a_y, friction = now.state[3:]
    return v_x, v_y + lead * (now.demand.a_y - yaw * v_x), yaw + lead * now.demand.yaw_acceleration, a_x, a_y, friction


def settled(allocator: Allocator, now: Situation, steps=600, tolerance=1e-7) -> SimpleNamespace:
    """The same situation again and again, until the commands stay."""
    scale = allocator.layout.scale
    for _ in range(steps):
        found = allocator.allocate(now)
        moved = float(np.max(np.abs(found.command - now.before) / scale))
        now = now._replace(before=found.command)
        if moved < tolerance:
            break
    return SimpleNamespace(found=found, command=found.command, moved=moved)


def constant_ahead(allocator, now: Situation) -> Situation:
    """With the demand of now for ever, for an allocator that looks ahead."""
    return now._replace(ahead=tuple(Ahead(t, now.demand, now.state.v_x, now.state.yaw_rate) for t in getattr(allocator, "horizon", ())))


def cornering(car: Car, v, a_x=0.0, a_y=0.0, v_y=0.0, friction=1.0, **more) -> Situation:
    """Steady motion: the demand that keeps yaw rate and side slip, and a_x."""
    state = VehicleState(0, 0, 0, v, v_y, a_y / v if v > 1.0 else 0.0, a_x, a_y, friction)
    return Situation(state, MotionDemand(a_x, a_y, 0.0), np.zeros(car.layout.size), car.spins(state[3:]), dt=DT)._replace(**more)
