"""Reduction of a machine whose equations do not change with its pose: connection and momentum.

With xi the body velocity (and the rates of joints without a motor), J_b xi + J_s r_dot = 0 the
constraints at a shape r, and B a basis of the null space of J_b, along which nothing holds the
machine, the momentum p = B^T (M_bb xi + M_bs r_dot) gives the rest of xi:

    xi = -A(r) r_dot + Gamma(r) p:      [J_b; B^T M_bb] (A, Gamma) = ([J_s; B^T M_bs], [0; 1])

No freedom left: kinematic, the shape alone moves it, whatever the masses. No constraints: p is the
whole momentum, which is kept, and from rest the shape alone moves it too. In between: mixed, p
changes by p_dot = mu . (B_dot + [xi, B]). A loop of the shape moves a machine with p = 0 by the
group's product of exp(-A dr), to first order in a small counter-clockwise loop's area by

    DA = d_1 A_2 - d_2 A_1 - [A_1, A_2]:       exp(-DA area).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from rrrobot.checks import Array, vector
from rrrobot.drive.gaits import Gait
from rrrobot.errors import ConstraintError, ModelError
from rrrobot.integrate import Stepping, integrate, sample_times
from rrrobot.machines.machine import Machine
from rrrobot.machines.singular import margin
from rrrobot.machines.solve import decompose
from rrrobot.rotations import quaternion_rate, rotation_from_quaternion

_STENCIL = ((1, 3 / 4), (2, -3 / 20), (3, 1 / 60))
"""Central differences of order six."""


class LocalForm(NamedTuple):
    """xi = -A r_dot + Gamma p at a shape."""

    connection: Array
    """A (nb, shape)"""
    response: Array
    """Gamma (nb, k): velocity per unit of each momentum"""
    free: Array
    """B (nb, k): orthonormal basis of what the constraints leave free"""
    rank: int
    """of J_b"""


class Reduction:
    """Connection, curvature and the net motion of cycles.

    Args:
        machine: planar, or afloat: its equations must not change with its pose.

    Raises:
        ModelError: gravity or a contact with the ground makes them change with it.

    Example:
        >>> import rrrobot as rr
        >>> snake = rr.machines.Reduction(rr.machines.kinematic_snake())
        >>> snake.kind, snake.connection((0.9, 0.5)).round(6).tolist()[0]
        ('kinematic', [0.125272, -0.108194])
    """

    def __init__(self, machine: Machine) -> None:
        model = machine.model
        if model.rolling is not None or not model.motors or _weighs(machine):
            raise ModelError(
                f"the {machine.name}'s equations change with its pose (gravity, or rolling on the "
                "ground), or it has no motors: it has no connection over its shape. Simulate it."
            )
        self.machine, self.model = machine, model
        moved = set(model.shape_v.tolist())
        self._base = np.array([i for i in range(model.model.nv) if i not in moved])
        self.group = "SE(2)" if model.planar else "SE(3)"

    @property
    def kind(self) -> str:
        """ "kinematic", "momentum" (kept, zero from rest) or "mixed", at a shape in general."""
        rng = np.random.default_rng(7)
        form = self.at(rng.uniform(0.2, 0.9, self.model.n_shape))
        if form.free.shape[1] == 0:
            return "kinematic"
        return "momentum" if form.rank == 0 else "mixed"

    def at(self, shape: ArrayLike) -> LocalForm:
        """The local form at a shape (n,).

        Raises:
            ConstraintError: the shape is singular for a kinematic machine: its rows contradict.
        """
        model, base, moved = self.model, self._base, self.model.shape_v
        z = model.start(None, vector("shape", shape, model.n_shape))
        q = model.coordinates.to_q(z)
        rows = model.rows(q, np.zeros(model.model.nv), 0.0, None)
        mass = model.mass_matrix(q)
        held, moving = rows.jacobian[:, base], rows.jacobian[:, moved]
        rank, left, _, right = decompose(held)
        if np.any(np.abs(left[:, rank:].T @ moving) > 1e-9):
            raise ConstraintError(
                f"{model._where(z, 0.0)()}: the constraints "
                f"{', '.join(repr(n) for n in model.names(None))} depend on each other and the "
                "shape cannot move freely there: the connection is singular."
            )
        free = right[rank:].T
        matrix = np.concatenate((held, free.T @ mass[np.ix_(base, base)]))
        target = np.concatenate((moving, free.T @ mass[np.ix_(base, moved)]))
        k = free.shape[1]
        unit = np.concatenate((np.zeros((held.shape[0], k)), np.eye(k)))
        both = np.linalg.lstsq(matrix, np.concatenate((target, unit), axis=1), rcond=1e-13)[0]
        return LocalForm(both[:, : len(moved)], both[:, len(moved) :], free, rank)

    def margin(self, shape: ArrayLike) -> float:
        """How far a shape is from a singular one, 0 to 1: least over greatest singular value of
        J_b; 1 where there is no constraint."""
        if not self.model.constraints:
            return 1.0
        return margin(self.model, vector("shape", shape, self.model.n_shape))

    def connection(self, shape: ArrayLike) -> Array:
        """A (nb, n): xi = -A r_dot where p = 0."""
        return self.at(shape).connection

    def curvature(self, shape: ArrayLike, first: int = 0, second: int = 1) -> Array:
        """DA (nb,) of two shape directions, the Lie bracket included; see the module's docstring.

        The derivatives are central differences of order six, good to about 1e-11.
        """
        r = vector("shape", shape, self.model.n_shape)
        unit = np.eye(self.model.n_shape)
        return self._flux(r, unit[first], unit[second])

    def _flux(self, r: Array, one: Array, two: Array) -> Array:
        """DA (nb,) of two directions in shape (n,)."""

        def slope(along: Array, other: Array) -> Array:
            size = float(np.linalg.norm(along))
            if size == 0:
                return np.zeros(self._base.size)
            step, total = 5e-3 / size, np.zeros(self._base.size)
            for k, weight in _STENCIL:
                for sign in (1, -1):
                    there = self.connection(r + sign * k * step * along)
                    total += sign * weight / step * (there @ other)
            return total

        A = self.connection(r)
        n = self.model.n_base
        flat = slope(one, two) - slope(two, one)
        flat[:n] -= bracket(A[:n] @ one, A[:n] @ two)
        return flat

    def line(self, gait: Gait, duration: float | None = None) -> Array:
        """Pose after a gait with p = 0 throughout: the ordered integral of -A dr.

        Equal to the dynamics for kinematic machines, and for kept momentum from rest. Planar pose
        (3,), or position and quaternion (7,).

        Raises:
            ModelError: the machine is mixed: its momentum changes, so simulate it.
        """
        if self.kind == "mixed":
            raise ModelError(
                f"the {self.machine.name} is mixed: its momentum does not stay zero. Simulate it."
            )
        end = gait.period if duration is None else duration
        if end is None:
            raise ModelError("the gait has no period: give a duration.")
        model = self.model

        def rate(time: float, z: Array) -> Array:
            motion = gait(time)
            v = np.zeros(model.model.nv)
            v[self._base] = -self.connection(motion.angle) @ motion.rate
            return model.coordinates.rate(z, v)

        start = model.start(self.machine._pose(None), gait(0.0).angle)
        times = sample_times(end, end)
        run = integrate(
            rate, start, times, Stepping(None, 1e-11, 1e-13, 0.1),
            correct=lambda _, z: model.coordinates.normalise(z),
        )  # fmt: skip
        if run.stop is not None:
            raise ConstraintError(run.stop + ".")
        return run.states[-1][: 3 if model.planar else 7]

    def area(self, gait: Gait, *, loops: int = 12) -> Array:
        """The same from the curvature: Stokes' theorem, ordered, for a closed gait.

        The loops r_s = r(0) + s (r - r(0)), s from 0 to 1, grow from a point to the gait. With
        g_s(t) the motion along one, its net motion G changes with s by

            dG/ds = W G,   W = - integral of Ad_g_s(t) DA(d_s r, d_t r) dt

        which for a plane body's turn is the plain area integral of -DA. W is taken at `loops`
        Gauss-Legendre nodes and is interpolated between them. Pose as of `line`.

        Raises:
            ModelError: a joint without a motor, no period, or a mixed machine.
        """
        n, period = self.model.n_base, gait.period
        if period is None or self._base.size != n:
            raise ModelError("area needs a gait with a period, and no joints without a motor.")
        if self.kind == "mixed":
            raise ModelError(f"the {self.machine.name} is mixed: simulate it.")
        origin = gait(0.0).angle
        place = [0, 1, 5] if n == 3 else list(range(6))

        def at(scale: float) -> Array:
            def rate(time: float, state: Array) -> Array:
                motion = gait(time)
                shape, turn = origin + scale * (motion.angle - origin), scale * motion.rate
                xi, flux = np.zeros(6), np.zeros(6)
                xi[place] = -self.connection(shape) @ turn
                flux[place] = -self._flux(shape, motion.angle - origin, turn)
                here = _se3(state)
                moved = here.rotation @ xi[:3]
                spin = quaternion_rate(state[3:7], xi[3:])
                return np.concatenate((moved, spin, here.action @ flux))

            start = np.zeros(13)
            start[6] = 1.0
            run = integrate(
                rate, start, np.array((0.0, period)), Stepping(None, 1e-9, 1e-12, period)
            )
            if run.stop is not None:
                raise ConstraintError(run.stop + ".")
            return run.states[-1][7:]

        nodes = 0.5 * (np.polynomial.legendre.leggauss(loops)[0] + 1)
        fit = np.linalg.solve(np.vander(2 * nodes - 1, loops), np.array([at(s) for s in nodes]))
        net = pin.SE3.Identity()
        steps = 64
        for i in range(steps):
            # Fourth-order Magnus over each of the short intervals.
            mid, half = (i + 0.5) / steps, np.sqrt(3) / 6 / steps
            one, two = (
                pin.Motion(np.vander([2 * s - 1], loops)[0] @ fit) for s in (mid - half, mid + half)
            )
            mean = 0.5 / steps * (one.vector + two.vector)
            twist = np.sqrt(3) / 12 / steps**2 * two.cross(one).vector
            net = pin.exp6(pin.Motion(mean + twist)) * net
        first = self.machine.model.start(self.machine._pose(None))[: 3 if n == 3 else 7]
        if n == 3:
            turn = np.arctan2(net.rotation[1, 0], net.rotation[0, 0])
            return first + np.array((*net.translation[:2], turn))
        begin = _se3(first)
        return np.concatenate(
            ((begin * net).translation, pin.Quaternion((begin * net).rotation).coeffs())
        )


def _se3(pose: Array) -> pin.SE3:
    return pin.SE3(rotation_from_quaternion(pose[3:7]), pose[:3])


def bracket(a: Array, b: Array) -> Array:
    """Lie bracket of body velocities: se(2) (3,) or se(3) (6,), linear before angular."""
    if a.size == 3:
        return np.array((-a[2] * b[1] + b[2] * a[1], a[2] * b[0] - b[2] * a[0], 0.0))
    return np.asarray(pin.Motion(a).cross(pin.Motion(b)).vector)


def _weighs(machine: Machine) -> bool:
    """Whether weight and buoyancy act on the base of a machine that leans."""
    model = machine.model
    z = model.start(None, np.full(len(model.motors), 0.3))
    if not model.planar:
        z[3:7] = (0.2, -0.3, 0.1, 0.927361849549570)
    load = model.applied(model.coordinates.to_q(z), np.zeros(model.model.nv), None)
    weight = pin.computeTotalMass(model.model) * float(np.abs(model.model.gravity.linear[2]))
    return bool(np.abs(load[: model.n_base]).max() > 1e-9 * weight)
