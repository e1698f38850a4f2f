"""RRRobot by SymPy's KanesMethod, lambdified, compiled by Numba, integrated by RK4.

Two ways to write it. "constraint": the centre's velocity is free, rolling is a velocity constraint,
and its two speeds are dependent, so the equations are 5 x 5, solved by numpy.linalg.solve: how the
documentation shows it. "kinematics": the centre's velocity is written from the angular velocity, so
the equations are 3 x 3, solved in closed form: the fastest that we found.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import sympy as sp
from numba import njit
from sympy.physics import mechanics as me

import rrrobot as rr
from benchmarks.common import AMPLITUDE, KAPPA, OMEGA, PERIOD, Array

FORMS = ("constraint", "kinematics")


def equations(form: str) -> tuple[Callable[..., tuple[float, ...]], int]:
    """Mass matrix and forcing, flat, as a Python function, and the number n of speeds.

    The function takes roll, pitch, yaw, n speeds (Euler rates, then the centre's velocity), the
    legs' angles, rates and accelerations, and r, b, l, the masses, g and the damping.
    """
    roll, pitch, yaw, *_ = q = me.dynamicsymbols("roll pitch yaw x y")
    u = me.dynamicsymbols("u1:6")
    phi = me.dynamicsymbols("phi1 phi2")
    r, b, leg, m_battery, m_servo, m_leg, g, kappa = constants = sp.symbols("r b l m_b m_s m_l g k")
    N = me.ReferenceFrame("N")
    A = N.orientnew("A", "Axis", (yaw, N.z))
    P = A.orientnew("P", "Axis", (pitch, A.y))
    B = P.orientnew("B", "Axis", (roll, P.x))
    for frame, before, speed in ((A, N, u[2] * N.z), (P, A, u[1] * A.y), (B, P, u[0] * P.x)):
        frame.set_ang_vel(before, speed)
    rolling = me.cross(B.ang_vel_in(N), r * N.z)
    centre = me.Point("C")
    centre.set_vel(N, u[3] * N.x + u[4] * N.y if form == "constraint" else rolling)
    hips = (-b * B.y, b * B.y)
    tips = [h + leg * (sp.cos(f) * B.x + sp.sin(f) * B.z) for h, f in zip(hips, phi, strict=True)]
    masses = (m_battery, m_servo, m_servo, m_leg, m_leg)
    bodies: list[Any] = []
    moments = ((A, kappa * (u[1] * A.y - u[2] * N.z)), (P, kappa * (u[0] * P.x - u[1] * A.y)))
    loads: list[Any] = [*moments, (B, -kappa * u[0] * P.x)]
    for i, (mass, arm) in enumerate(zip(masses, (-r * B.z, *hips, *tips), strict=True)):
        point = centre.locatenew(f"P{i}", arm)
        point.set_vel(B, arm.dt(B))
        point.v1pt_theory(centre, N, B)
        bodies.append(me.Particle(f"M{i}", point, mass))
        loads.append((point, -mass * g * N.z))
    n = 5 if form == "constraint" else 3
    slip = centre.vel(N) - rolling
    dependent = {
        "u_dependent": u[3:],
        "velocity_constraints": [slip.dot(N.x), slip.dot(N.y)],
    }
    kane = me.KanesMethod(
        N, q[:n], u[:3], kd_eqs=[a.diff() - b for a, b in zip(q[:n], u[:n], strict=True)],
        **(dependent if n == 5 else {}),
    )  # fmt: skip
    kane.kanes_equations(bodies, loads)
    return _lambdified(kane, q[:3], u[:n], phi, constants), n


def _lambdified(kane: Any, q: Any, u: Any, phi: Any, constants: Any) -> Any:
    rates, accelerations = [f.diff() for f in phi], [f.diff().diff() for f in phi]
    names = [sp.Dummy() for _ in (*q, *u, *phi, *rates, *accelerations)]
    plain = dict(zip((*q, *u, *phi, *rates, *accelerations), names, strict=True))
    # Derivatives go first, the highest before the lower.
    order = sorted(plain, key=lambda f: -f.derivative_count if f.is_Derivative else 0)
    flat = []
    for entry in (*kane.mass_matrix, *kane.forcing):
        for f in order:
            entry = entry.xreplace({f: plain[f]})
        flat.append(sp.Float(entry) if entry.is_Integer else entry)
    return sp.lambdify([*names, *constants], tuple(flat), modules="math", cse=True)


def simulator(form: str, *, compiled: bool = True) -> Callable[..., None]:
    """A loop over gaits: f(offset, phase, starts, steps, means).

    starts (gaits, 5 + n) are states (roll, pitch, yaw, x, y, speeds); means (gaits, cycles, 3)
    take the cycle means of x, y and yaw.
    """
    jit = njit(error_model="numpy") if compiled else lambda function: function
    function, n = equations(form)
    terms = jit(function)
    p = rr.RRRobotParameters()
    r, b, leg, g = p.shell_radius, p.hip_offset, p.leg_lengths[0], p.gravity
    battery, servo, tip = p.battery_mass, p.servo_masses[0], p.leg_masses[0]

    @jit
    def rate(t, y, offset, phase, out):  # type: ignore[no-untyped-def]
        s1, s2 = AMPLITUDE * np.sin(OMEGA * t), AMPLITUDE * np.sin(OMEGA * t + phase)
        d1, d2 = np.cos(OMEGA * t), np.cos(OMEGA * t + phase)
        f = AMPLITUDE * OMEGA
        legs = (offset + s1, offset + s2, f * d1, f * d2, -(OMEGA**2) * s1, -(OMEGA**2) * s2)
        out[:3] = y[5:8]
        if n == 5:
            speeds = (y[5], y[6], y[7], y[8], y[9])
            v = terms(y[0], y[1], y[2], *speeds, *legs, r, b, leg, battery, servo, tip, g, KAPPA)
            matrix, force = np.empty((n, n)), np.empty(n)
            for i in range(n):
                for j in range(n):
                    matrix[i, j] = v[n * i + j]
                force[i] = v[n * n + i]
            out[3:5] = y[8:10]
            out[5:] = np.linalg.solve(matrix, force)
            return
        speeds = (y[5], y[6], y[7])
        m = terms(y[0], y[1], y[2], *speeds, *legs, r, b, leg, battery, servo, tip, g, KAPPA)
        ahead, across = np.cos(y[1]) * y[5], y[6]
        out[3] = r * (np.sin(y[2]) * ahead + np.cos(y[2]) * across)
        out[4] = r * (np.sin(y[2]) * across - np.cos(y[2]) * ahead)
        a, b_, c = m[4] * m[8] - m[5] * m[5], m[2] * m[5] - m[1] * m[8], m[1] * m[5] - m[2] * m[4]
        d, e, f_ = m[0] * m[8] - m[2] * m[2], m[1] * m[2] - m[0] * m[5], m[0] * m[4] - m[1] * m[1]
        over = 1.0 / (m[0] * a + m[1] * b_ + m[2] * c)
        out[5] = over * (a * m[9] + b_ * m[10] + c * m[11])
        out[6] = over * (b_ * m[9] + d * m[10] + e * m[11])
        out[7] = over * (c * m[9] + e * m[10] + f_ * m[11])

    @jit
    def run(offset, phase, starts, steps, means):  # type: ignore[no-untyped-def]
        h, size = PERIOD / steps, 5 + n
        k1, k2, k3, k4 = np.empty(size), np.empty(size), np.empty(size), np.empty(size)
        work = np.empty(size)
        means[:] = 0.0
        for lane in range(offset.size):
            y = starts[lane].copy()
            o, p = offset[lane], phase[lane]
            for cycle in range(means.shape[1]):
                mean = means[lane, cycle]
                for step in range(steps):
                    t = h * step
                    for i in range(3):
                        mean[i] += 0.5 * y[(3, 4, 2)[i]]
                    rate(t, y, o, p, k1)
                    for i in range(size):
                        work[i] = y[i] + 0.5 * h * k1[i]
                    rate(t + 0.5 * h, work, o, p, k2)
                    for i in range(size):
                        work[i] = y[i] + 0.5 * h * k2[i]
                    rate(t + 0.5 * h, work, o, p, k3)
                    for i in range(size):
                        work[i] = y[i] + h * k3[i]
                    rate(t + h, work, o, p, k4)
                    for i in range(size):
                        y[i] += h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i])
                    for i in range(3):
                        mean[i] += 0.5 * y[(3, 4, 2)[i]]
                for i in range(3):
                    mean[i] /= steps

    return run  # type: ignore[no-any-return]


def starts(form: str, omega: Array) -> Array:
    """States of upright starts with the angular velocities omega (gaits, 3)."""
    r = rr.RRRobotParameters().shell_radius
    n = len(omega)
    parts = [np.zeros((n, 5)), omega]
    if form == "constraint":
        parts.append(r * np.column_stack((omega[:, 1], -omega[:, 0])))
    return np.concatenate(parts, axis=1)
