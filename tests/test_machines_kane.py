"""Machines in space against Kane's equations, of kinematics by SymPy, at random states.

Nothing of the package's mechanics is used. Bodies move by x, y, z, by angles of R = Rz(yaw)
Rx(lean) Ry(spin), and by joints; with v and w of a body's mass centre in its own axes,

    sum over bodies of  (dv/du)^T (M v_dot + w x M v - R^T f) + (dw/du)^T (I w_dot + w x I w
                        + v x M v)  =  tau + J^T lambda,          J u_dot + drift = 0,

u the coordinates' rates, M a mass, or a mass along each axis where a fluid adds one.
"""

from functools import reduce

import numpy as np
import pytest
import sympy as sp

import rrrobot as rr

G = 9.81
BASE = sp.symbols("x y z yaw lean spin")
BASE_RATES = sp.symbols("dx dy dz dyaw dlean dspin")


def turn(axis, angle):
    """R_parent_child of a turn about x, y, z or -y."""
    c, s = sp.cos(angle), sp.sin(angle)
    return {
        "x": sp.Matrix([[1, 0, 0], [0, c, -s], [0, s, c]]),
        "y": sp.Matrix([[c, 0, s], [0, 1, 0], [-s, 0, c]]),
        "z": sp.Matrix([[c, -s, 0], [s, c, 0], [0, 0, 1]]),
        "-y": sp.Matrix([[c, 0, -s], [0, 1, 0], [s, 0, c]]),
    }[axis]


def axis_of(name):
    unit = sp.Matrix([1 if k == name[-1] else 0 for k in "xyz"])
    return -unit if name[0] == "-" else unit


class Frame:
    """Axes that move: rotation R, and velocities of the origin and the axes, in the axes."""

    def __init__(self, R, v, w):
        self.R, self.v, self.w = R, v, w

    def child(self, axis, angle, rate, at=(0, 0, 0)):
        T = turn(axis, angle)
        moved = self.v + self.w.cross(sp.Matrix(at))
        return Frame(self.R * T, T.T * moved, T.T * self.w + axis_of(axis) * rate)

    def slid(self, axis, travel, rate):
        e = axis_of(axis)
        return Frame(self.R, self.v + self.w.cross(e * travel) + e * rate, self.w)

    def speed(self, point):
        return self.v + self.w.cross(sp.Matrix(point))


def angled(angles, rates, velocity):
    """Axes of yaw, lean, spin, with a velocity in the world."""
    yaw, lean, spin = (turn(k, a) for k, a in zip("zxy", angles, strict=True))
    w = spin.T * (lean.T * sp.Matrix([0, 0, rates[0]]) + sp.Matrix([rates[1], 0, 0]))
    R = yaw * lean * spin
    return Frame(R, R.T * sp.Matrix(velocity), w + sp.Matrix([0, rates[2], 0]))


class System:
    """Coordinates, bodies (frame, centre, masses (3,), inertia, force in the world), rows."""

    def __init__(self, *joints):
        self.joints = sp.symbols(" ".join(joints) + ",") if joints else ()
        self.joint_rates = sp.symbols(" ".join(f"d{j}" for j in joints) + ",") if joints else ()
        self.q, self.u = [*BASE, *self.joints], [*BASE_RATES, *self.joint_rates]
        self.base = angled(BASE[3:], BASE_RATES[3:], BASE_RATES[:3])
        self.bodies, self.rows = [], []

    def add(self, frame, mass, inertia, centre=(0, 0, 0), gravity=G):
        masses = np.broadcast_to(mass, 3)
        inertia = np.diag(np.broadcast_to(inertia, 3)) if np.ndim(inertia) < 2 else inertia
        self.bodies.append(
            (frame, centre, masses, inertia, (0, 0, -float(np.mean(mass)) * gravity))
        )

    def roll(self, arm, extra=(0, 0, 0)):
        """The base's shell rolls: arm is from the origin to the contact, in the body's axes."""
        self.rows += list(self.base.v + self.base.w.cross(arm) - sp.Matrix(extra))

    def solve(self, q, u, prescribed, rates=0.0):
        """u_dot, the rows' forces, the joints' torques, and the base's w_dot.

        Joints have prescribed accelerations, and the rows the rates that drive them.
        """
        moves = dict(zip(self.q, self.u, strict=True))

        def parts(expression):
            e = sp.Matrix(expression)
            drift = sum((sp.diff(e, c) * r for c, r in moves.items()), sp.zeros(*e.shape))
            return e, e.jacobian(self.u), drift

        wanted = [parts(part) for frame, centre, *_ in self.bodies
                  for part in (frame.speed(centre), frame.w)]  # fmt: skip
        wanted += [parts(self.rows or sp.zeros(1, 1)), parts(self.base.w)]
        flat = [item for part in wanted for item in part] + [b[0].R for b in self.bodies]
        numbers = sp.lambdify((*self.q, *self.u), flat, "numpy", cse=True)(*q, *u)
        numbers = [np.array(x, dtype=float) for x in numbers]
        n = len(self.q)
        mass, load = np.zeros((n, n)), np.zeros(n)
        for i, (_, _, masses, inertia, force) in enumerate(self.bodies):
            v, Jv, dv, w, Jw, dw = (x.squeeze() for x in numbers[6 * i : 6 * i + 6])
            R = numbers[6 * len(self.bodies) + 6 + i]
            push = masses * dv + np.cross(w, masses * v) - R.T @ force
            twist = inertia @ dw + np.cross(w, inertia @ w) + np.cross(v, masses * v)
            mass += Jv.T @ (masses[:, None] * Jv) + Jw.T @ inertia @ Jw
            load += Jv.T @ push + Jw.T @ twist
        _, J, drift, _, Jw, dw = numbers[6 * len(self.bodies) : 6 * len(self.bodies) + 6]
        J, drift = J[: len(self.rows)], drift.ravel()[: len(self.rows)]
        k = len(self.joints)
        rows = np.concatenate((J, np.eye(n)[n - k :]))
        m = len(rows)
        matrix = np.block([[mass, -rows.T], [rows, np.zeros((m, m))]])
        right = np.concatenate((-load, rates - drift, prescribed))
        found = np.linalg.solve(matrix, right)
        return found[:n], found[n : n + m - k], found[n + m - k :], Jw @ found[:n] + dw.ravel()


def up(frame, normal=(0, 0, 1)):
    return frame.R.T * sp.Matrix(normal)


def rolling_disc():
    s = System()
    s.add(s.base, 1.2, (0.03, 0.055, 0.03))
    e = -up(s.base)
    s.roll(0.3 * sp.Matrix([e[0], 0, e[2]]) / sp.sqrt(e[0] ** 2 + e[2] ** 2) + 0.02 * e)
    return s


def ball_on_slope():
    s = System()
    s.add(s.base, 1.0, 0.4 * 0.1**2)
    s.roll(-0.1 * up(s.base, (np.sin(0.3), 0, np.cos(0.3))))
    return s


def turntable_ball():
    s = System()
    s.add(s.base, 1.0, 0.4 * 0.1**2)
    carried = 2.0 * sp.Matrix([-BASE[1], BASE[0], 0])
    s.roll(-0.1 * up(s.base), s.base.R.T * carried)
    return s


def chaplygin_sphere():
    s = System()
    s.add(s.base, 1.0, (0.010, 0.014, 0.018))
    s.roll(-0.2 * up(s.base))
    return s


def routh_sphere():
    s = System()
    s.add(s.base, 1.0, (0.012, 0.012, 0.016), (0, 0, -0.05))
    s.roll(-0.2 * up(s.base))
    return s


def rattleback():
    s = System()
    inertia = np.diag((2e-4, 16e-4, 17e-4))
    inertia[0, 1] = inertia[1, 0] = 0.2e-4
    s.add(s.base, 1.0, inertia, (0, 0, -0.01))
    e = -up(s.base)
    A = sp.diag(0.2**2, 0.03**2, 0.02**2)
    s.roll(A * e / sp.sqrt((e.T * A * e)[0]))
    return s


def pendulum_ball():
    s = System("drive", "tilt")
    yoke = s.base.child("y", s.joints[0], s.joint_rates[0])
    s.add(s.base, 0.6, 0.016)
    s.add(yoke, 0.2, (2e-4, 3e-4, 2e-4))
    inner = yoke.child("x", s.joints[1], s.joint_rates[1])
    s.add(inner, 1.5, (4e-4, 5e-4, 3e-4), (0, 0, -0.12))
    s.roll(-0.2 * up(s.base))
    return s


def rotors(s, spins, inertia, mass, **more):
    s.add(s.base, mass, np.array(inertia) - spins, **more)
    for k, spin, angle, rate in zip("xyz", spins, s.joints, s.joint_rates, strict=True):
        s.add(s.base.child(k, angle, rate), 0.0, spin * np.array([k == a for a in "xyz"]))


def rotor_ball():
    s = System("a", "b", "c")
    rotors(s, np.full(3, 8e-4), (0.009,) * 3, 1.0)
    s.roll(-0.15 * up(s.base))
    return s


def on_legs(gravity):
    p = rr.RRRobotParameters()
    s = System("leg_1", "leg_2")
    s.add(s.base, p.battery_mass, 0.0, (0, 0, -p.shell_radius), gravity)
    for i, side in enumerate((-1, 1)):
        at = (0, side * p.hip_offset, 0)
        s.add(s.base, p.servo_masses[i], 0.0, at, gravity)
        leg = s.base.child("-y", s.joints[i], s.joint_rates[i], at)
        s.add(leg, p.leg_masses[i], 0.0, (p.leg_lengths[i], 0, 0), gravity)
    return s


def legged_satellite():
    return on_legs(0.0)


def rrrobot():
    s = on_legs(G)
    s.roll(-rr.RRRobotParameters().shell_radius * up(s.base))
    return s


def falling_cat():
    s = System("turn", "bend", "back")
    half = (0.01, 0.05, 0.05)
    joints = zip("xyx", s.joints, s.joint_rates, strict=True)
    rear = reduce(lambda frame, joint: frame.child(*joint), joints, s.base)
    s.add(s.base, 1.0, half, (-0.2, 0, 0), gravity=0)
    s.add(rear, 1.0, half, (0.2, 0, 0), gravity=0)
    return s


ADDED = (8.018079007, 37.72874897, 65.82858913), (0.05853949792, 2.179401169, 1.083471016)
M_BOAT = 1000 * 4 / 3 * np.pi * 0.5 * 0.2 * 0.15


def submarine():
    s = System("a", "b", "c")
    h = 0.02
    about = np.array((0.6, 2.4, 2.6)) - M_BOAT * h * h * np.array((1, 1, 0))
    rotors(s, np.array((0.02, 0.03, 0.03)), about, M_BOAT, centre=(0, 0, -h))
    s.add(s.base, ADDED[0], ADDED[1], gravity=-M_BOAT * G / np.mean(ADDED[0]))  # buoyancy
    return s


def moving_mass():
    s = System("x_", "y_", "z_")
    s.add(s.base, M_BOAT, (0.6, 2.4, 2.6), gravity=0)
    s.add(s.base, ADDED[0], ADDED[1], gravity=0)
    slides = zip("xyz", s.joints, s.joint_rates, strict=True)
    s.add(reduce(lambda frame, slide: frame.slid(*slide), slides, s.base), 5.0, 0.0, gravity=0)
    return s


MACHINES = {
    "rolling_disc": (rolling_disc, {"A": 0.03, "C": 0.055, "rho": 0.02}),
    "ball_on_slope": (ball_on_slope, {}),
    "turntable_ball": (turntable_ball, {}),
    "chaplygin_sphere": (chaplygin_sphere, {}),
    "routh_sphere": (routh_sphere, {}),
    "rattleback": (rattleback, {}),
    "pendulum_ball": (pendulum_ball, {}),
    "rotor_ball": (rotor_ball, {}),
    "rrrobot": (rrrobot, {}),
    "legged_satellite": (legged_satellite, {}),
    "falling_cat": (falling_cat, {}),
    "submarine": (submarine, {}),
    "submarine, moving mass": (moving_mass, {"mp": 5.0, "h": 0.0}),
}


def number(expression, symbols, values):
    return np.array(
        sp.Matrix(expression).subs(dict(zip(symbols, values, strict=True))), dtype=float
    )


@pytest.mark.parametrize("name", MACHINES)
def test_kane_gives_the_same(name):
    write_down, parameters = MACHINES[name]
    machine = rr.machines.by_name(name.split(",")[0], **parameters)
    s = write_down()
    rng = np.random.default_rng(5)
    k = len(s.joints)
    q = np.concatenate(((0.1, -0.2, 0.4), rng.uniform(0.2, 0.6, 3 + k)))
    u = rng.normal(size=6 + k)
    wanted = rng.normal(size=k)
    every, values = [*s.q, *s.u], [*q, *u]
    if s.rows:
        slip = sp.Matrix(s.rows)
        J = number(slip.jacobian(s.u[:3]), every, values)
        u[:3] -= np.linalg.solve(J, number(slip, every, values).ravel())
        values = [*q, *u]
    R = number(s.base.R, every, values)
    v, w = (number(part, every, values).ravel() for part in (s.base.v, s.base.w))
    a, force, torque, w_dot = s.solve(q, u, wanted)
    drive = {"shape": q[6:], "shape_rates": u[6:], "shape_accelerations": wanted} if k else {}
    found = machine.evaluate(
        pose=machine.at(R, q[:3]), body_velocity=np.concatenate((v, w)), **drive
    )
    np.testing.assert_allclose(found.pose_acceleration[:3], a[:3], rtol=1e-8, atol=1e-8)
    np.testing.assert_allclose(found.pose_acceleration[3:], R @ w_dot, rtol=1e-8, atol=1e-8)
    np.testing.assert_allclose(found.joint_torques, torque, rtol=1e-7, atol=1e-9)
    if s.rows:
        np.testing.assert_allclose(found.multipliers["contact"], R @ force, rtol=1e-8, atol=1e-9)


def test_kane_gives_the_sphericle():
    # Two bodies about one centre; the vehicle's own angles stand for joints, and rows drive it.
    import pinocchio as pin

    s = System("yaw_2", "lean_2", "spin_2")
    velocity = sp.Matrix(BASE_RATES[:3])
    inner = angled(s.joints, s.joint_rates, velocity)
    s.add(s.base, 0.5, 1 / 75)
    s.add(inner, 1.2, (3e-3, 4e-3, 2.5e-3), (0, 0, -0.12))
    s.roll(-0.2 * up(s.base))
    relative = inner.w - inner.R.T * (s.base.R * s.base.w)
    u1, u2, a1, a2 = 0.3, 0.8, 0.5, -0.4
    s.rows += list(relative)
    s.joints = ()  # no motor holds the angles: the rows do
    q = np.array((0.1, -0.2, 0.4, 0.3, 0.2, -0.4, 0.2, -0.3, 0.5))
    w_shell = np.array((0.2, 0.9, -0.3))
    numbers = dict(zip(s.q, q, strict=True))
    jacobian = sp.Matrix([*s.base.w, *s.rows]).jacobian(s.u).subs(numbers)
    # Rates that turn the shell by w_shell, roll, and drive the vehicle.
    asked = np.concatenate((w_shell, np.zeros(3), (0, -u1 / 0.18, u2)))
    u = np.linalg.solve(np.array(jacobian, dtype=float), asked)
    rates = np.array((0, 0, 0, 0, -a1 / 0.18, a2))
    a, force, _, w_dot = s.solve(q, u, (), rates)
    R, R2 = (np.array(f.R.subs(numbers), dtype=float) for f in (s.base, inner))
    ball = rr.machines.sphericle()
    found = ball.evaluate(
        pose=ball.at(R, q[:3]), passive={"vehicle": pin.Quaternion(R.T @ R2).coeffs()},
        body_velocity=w_shell, shape_rates=(u1, u2), shape_accelerations=(a1, a2),
    )  # fmt: skip
    np.testing.assert_allclose(found.pose_acceleration[:3], a[:3], atol=1e-9)
    np.testing.assert_allclose(found.pose_acceleration[3:], R @ w_dot, atol=1e-9)
    np.testing.assert_allclose(found.multipliers["drive"], force[3:], atol=1e-9)
