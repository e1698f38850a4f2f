"""Planar machines against Lagrange-d'Alembert equations derived here with SymPy, at random states.

Nothing of the package's mechanics is used: each machine is written down anew as bodies with a
position and an angle, and skates, and its accelerations are solved from

    d/dt dT/dq_dot - dT/dq = tau + J^T lambda,      J q_dd + J_dot q_dot = 0.
"""

import numpy as np
import pytest
import sympy as sp

import rrrobot as rr

X, Y, TH = sp.symbols("x y th")


def at(point, angle, along, across=0):
    """A point along and across a direction from another."""
    c, s = sp.cos(angle), sp.sin(angle)
    return (point[0] + along * c - across * s, point[1] + along * s + across * c)


def snakeboard():
    psi, f, b = shape = sp.symbols("psi f b")
    o, l = (X, Y), 0.2  # noqa: E741
    front, back = at(o, TH, l), at(o, TH, -l)
    bodies = [(6.0, 0.016, o, TH), (0, 0.072, o, TH + psi), (0, 0.0013, front, TH + f),
              (0, 0.0013, back, TH + b)]  # fmt: skip
    return shape, bodies, [(front, TH + f), (back, TH + b)]


def roller_racer():
    (phi,) = shape = sp.symbols("phi,")
    o = (X, Y)
    joint = at(o, TH, 0.35)
    bodies = [(2.5, 0.05, at(o, TH, 0.12), TH), (0.6, 0.004, at(joint, TH + phi, -0.05), TH + phi)]
    return shape, bodies, [(o, TH), (at(joint, TH + phi, -0.08), TH + phi)]


def trikke():
    phi, gamma = shape = sp.symbols("phi gamma")
    o = (X, Y)
    joint = at(o, TH, 0.55)
    bodies = [
        (4.0, 0.15, at(o, TH, 0.2), TH),
        (1.2, 0.02, at(joint, TH + phi, 0.02), TH + phi),
        (2.0, 0.01, at(at(o, TH, 0.15), TH + gamma, 0.25), TH + gamma),
    ]
    return shape, bodies, [(o, TH), (at(joint, TH + phi, -0.06), TH + phi)]


def kinematic_snake():
    a1, a2 = shape = sp.symbols("a1 a2")
    o, L = (X, Y), 0.15
    rear, front = at(at(o, TH, -L), TH + a1, -L), at(at(o, TH, L), TH + a2, L)
    bodies = [(0.5, 0.00375, p, t) for p, t in ((o, TH), (rear, TH + a1), (front, TH + a2))]
    return shape, bodies, [(rear, TH + a1), (o, TH), (front, TH + a2)]


def chaplygin_sleigh():
    (psi,) = shape = sp.symbols("psi,")
    o = (X, Y)
    c = at(o, TH, 0.2)
    return shape, [(1.5, 0.04, c, TH), (0, 0.01, c, TH + psi)], [(o, TH)]


def satellite():
    a1, a2 = shape = sp.symbols("a1 a2")
    o = (X, Y)
    bodies = [
        (10.0, 0.5, o, TH),
        (1.5, 0.03, at(at(o, TH, -0.3), TH + a1, -0.25), TH + a1),
        (1.0, 0.02, at(at(o, TH, 0.3), TH + a2, 0.2), TH + a2),
    ]
    return shape, bodies, []


def accelerations(shape, bodies, skates, q, v, torque):
    """q_dd and the skates' forces at a state."""
    names = (X, Y, TH, *shape)
    rates = sp.symbols(f"v0:{len(names)}")

    def rate(expression):
        return sum(sp.diff(expression, n) * r for n, r in zip(names, rates, strict=True))

    kinetic = sum(
        m * (rate(p[0]) ** 2 + rate(p[1]) ** 2) / 2 + inertia * rate(t) ** 2 / 2
        for m, inertia, p, t in bodies
    )
    slips = [-sp.sin(t) * rate(p[0]) + sp.cos(t) * rate(p[1]) for p, t in skates]
    momenta = [sp.diff(kinetic, r) for r in rates]
    mass = sp.Matrix(momenta).jacobian(rates)
    bias = sp.Matrix([rate(p) - sp.diff(kinetic, n) for p, n in zip(momenta, names, strict=True)])
    rows = sp.Matrix(slips).jacobian(rates) if slips else sp.zeros(0, len(names))
    drift = sp.Matrix([rate(s) for s in slips])
    number = sp.lambdify((*names, *rates), [mass, bias, rows, drift], "numpy")
    M, h, J, g = (np.array(part, dtype=float) for part in number(*q, *v))
    n, m = len(names), len(slips)
    J, g = J.reshape(m, n), g.reshape(m)
    matrix = np.block([[M, -J.T], [J, np.zeros((m, m))]])
    push = np.concatenate((np.zeros(3), torque))
    found = np.linalg.solve(matrix, np.concatenate((push - h.ravel(), -g)))
    return found[:n], found[n:], J


MACHINES = {
    "snakeboard": (snakeboard, {}),
    "roller_racer": (roller_racer, {"d1": 0.35, "d2": -0.08, "m1": 2.5, "I1": 0.05, "c1": 0.12,
                                    "m2": 0.6, "I2": 0.004, "c2": -0.05}),
    "trikke": (trikke, {}),
    "kinematic_snake": (kinematic_snake, {}),
    "chaplygin_sleigh": (chaplygin_sleigh, {"Jr": 0.01}),
    "satellite": (satellite, {}),
}  # fmt: skip


@pytest.mark.parametrize("name", MACHINES)
def test_lagrange_gives_the_same(name):
    write_down, parameters = MACHINES[name]
    machine = rr.machines.by_name(name, **parameters)
    shape, bodies, skates = write_down()
    rng = np.random.default_rng(11)
    q = np.concatenate(((0.1, -0.2, 0.3), rng.uniform(0.3, 0.9, len(shape))))
    torque = rng.normal(size=len(shape))
    v = rng.normal(size=q.size)
    rows = accelerations(shape, bodies, skates, q, v, torque)[2]
    v -= np.linalg.pinv(rows) @ (rows @ v)
    wanted, forces, _ = accelerations(shape, bodies, skates, q, v, torque)
    c, s = np.cos(q[2]), np.sin(q[2])
    body = (c * v[0] + s * v[1], -s * v[0] + c * v[1], v[2])
    found = machine.evaluate(
        pose=q[:3], shape=q[3:], shape_rates=v[3:], body_velocity=body, joint_torques=torque
    )
    both = np.concatenate((found.pose_acceleration, found.shape_accelerations))
    np.testing.assert_allclose(both, wanted, rtol=1e-10, atol=1e-10)
    np.testing.assert_allclose([*found.multipliers.values()], forces, rtol=1e-9, atol=1e-10)
    # Prescribed motors give the torques back.
    back = machine.evaluate(
        pose=q[:3], shape=q[3:], shape_rates=v[3:], body_velocity=body,
        shape_accelerations=wanted[3:],
    )  # fmt: skip
    np.testing.assert_allclose(back.joint_torques, torque, rtol=1e-8, atol=1e-9)
