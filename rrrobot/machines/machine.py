"""A machine: its tree, its equations, its gaits; evaluated at a state and simulated."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from rrrobot.checks import Array, vector
from rrrobot.drive.gaits import Gait, LegMotion
from rrrobot.errors import ModelError, ParameterError, SimulationError, SimulationInterrupted
from rrrobot.inline import html_table
from rrrobot.integrate import Stepping, integrate, sample_times
from rrrobot.machines.history import History
from rrrobot.machines.lone import roll, rolls_alone
from rrrobot.machines.mechanism import Mechanism
from rrrobot.machines.singular import refuse_singular
from rrrobot.machines.tree import Tree
from rrrobot.rotations import rotation_from_quaternion

_WORLD = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
TorqueLaw = Callable[[float, Array, Array], ArrayLike]
"""(time, shape, shape rates) -> joint torques (n,)."""


class Evaluation(NamedTuple):
    """A machine's accelerations and forces at a state."""

    pose_acceleration: Array
    """of the base frame, in the world: (x, y, theta) (3,) in the plane; in space (6,), linear (the
    classical acceleration of the frame's origin) and angular [m/s^2, rad/s^2]"""
    shape_accelerations: Array
    """(n,) [rad/s^2]"""
    joint_torques: Array
    """(n,) [N m]"""
    multipliers: dict[str, float | Array]
    """force of each constraint by its name [N, N m]"""
    velocity: Array
    """v of the whole machine (nv,), passive joints completed"""
    acceleration: Array
    """v_dot (nv,), Pinocchio's"""


@dataclass(frozen=True, eq=False, kw_only=True)
class Machine:
    """A machine that moves by its shape, or by itself.

    Attributes:
        name: short name; `title`: what it is, in words.
        tree: links and joints, and the URDF.
        model: equations of motion.
        gaits: by name.
        shape: at which it starts by itself (n,).

    Example:
        >>> import rrrobot as rr
        >>> board = rr.machines.snakeboard()
        >>> t = board.simulate(board.gaits["drive"], 6.283185307179586)
        >>> t.pose[-1].round(6).tolist()
        [0.124403, -0.00119, -0.060474]
    """

    name: str
    title: str
    tree: Tree
    model: Mechanism
    gaits: Mapping[str, Gait] = field(default_factory=dict)
    shape: tuple[float, ...] = ()
    pose: tuple[float, ...] | None = None
    velocity: tuple[float, ...] | None = None
    """body velocity at which it starts by itself; its pose likewise"""

    def __post_init__(self) -> None:
        self.model.machine = self
        if not self.model.planar:
            self._check_body()

    def _check_body(self) -> None:
        """Raise where the whole, joints locked, has an inertia that no body has.

        A link alone may: a rotor's spin inertia is its own, the rest is its carrier's.
        """
        pin_model = self.model.model
        mass = pin.crba(pin_model, pin_model.createData(), self.model.coordinates.to_q(
            self.model.start(None, self.shape or None)))[:6, :6]  # fmt: skip
        arm = mass[:3, 3:] / mass[0, 0]
        moments = np.linalg.eigvalsh(mass[3:, 3:] - mass[0, 0] * arm.T @ arm)
        if moments[2] > (1 + 1e-9) * (moments[0] + moments[1]):
            shown = ", ".join(f"{x:.4g}" for x in moments)
            raise ParameterError(
                f"the {self.name} as a whole has the moments {shown} kg m^2 about its mass centre: "
                "the greatest may be no more than the others' sum. Is an inertia too large?"
            )

    def _repr_html_(self) -> str:
        rows = {
            "gaits": ", ".join(self.gaits) or "it moves by itself",
            "motors": ", ".join(self.model.motors) or "none",
            "links": ", ".join((self.tree.base.name, *(j.child.name for j in self.tree.joints))),
        }
        return html_table(self.title, rows)

    @property
    def urdf(self) -> str:
        """URDF text of the tree.

        Raises:
            ModelError: a joint is spherical.
        """
        return self.tree.urdf(self.name)

    def at(self, rotation: ArrayLike, position: ArrayLike = (0.0, 0.0)) -> Array:
        """Pose (7,) of a machine in space: resting on its ground at a contact point (2,), or at a
        position (3,), with a rotation (3, 3) or quaternion (x, y, z, w)."""
        if self.model.planar:
            raise ModelError(f"the {self.name} moves in the plane: its pose is (x, y, theta).")
        given = np.asarray(rotation, dtype=float)
        quaternion = pin.Quaternion(given).coeffs() if given.shape == (3, 3) else given
        matrix = rotation_from_quaternion(vector("rotation", quaternion, 4))
        place = np.asarray(position, dtype=float)
        contact = self.model.rolling
        if place.shape == (3,):
            return np.concatenate((place, quaternion))
        place = vector("position", place, 2, "m")
        if contact is None:
            return np.concatenate((place, (0.0,), quaternion))
        ground = contact.ground.point(place)
        arm = contact.surface.arm(matrix, contact.ground.normal(ground))
        centre = self.model.model.frames[contact.frame_id].placement.translation
        return np.concatenate((ground - arm - matrix @ centre, quaternion))

    def evaluate(
        self,
        *,
        pose: ArrayLike | None = None,
        shape: ArrayLike | None = None,
        shape_rates: ArrayLike | None = None,
        body_velocity: ArrayLike | None = None,
        shape_accelerations: ArrayLike | None = None,
        joint_torques: ArrayLike | None = None,
        passive: Mapping[str, ArrayLike] | None = None,
        time: float = 0.0,
    ) -> Evaluation:
        """Accelerations and forces at a state.

        Args:
            pose: (x, y, theta); in space (7,), or a rotation (3, 3): see `at`.
            shape, shape_rates: of the motors (n,); zero unless given.
            body_velocity: (forward, left, yaw rate); in space (6,), linear and angular in body
                axes, or the angular part (3,) alone: the constraints give the rest.
            shape_accelerations: of prescribed motors (n,), or
            joint_torques: of torque-driven ones (n,).
            passive: coordinates of joints without a motor, by name; their rates follow from the
                constraints.

        Raises:
            ConstraintError: velocities that break a constraint, or constraints that contradict.
            ModelError: both accelerations and torques are given.
        """
        if shape_accelerations is not None and joint_torques is not None:
            raise ModelError("give shape_accelerations or joint_torques, not both.")
        model, n = self.model, self.model.n_shape
        z = model.start(self._pose(pose), shape if model.motors else None, passive)
        rates = np.zeros(n) if shape_rates is None else vector("shape_rates", shape_rates, n)
        motion, torque = None, None
        known: dict[int, float] = {}
        if joint_torques is None:
            given = np.zeros(n) if shape_accelerations is None else shape_accelerations
            a = vector("shape_accelerations", given, n)
            angle = np.zeros(n) if shape is None else np.asarray(shape, dtype=float)
            motion = LegMotion(angle, rates, a) if n else None
        else:
            torque = vector("joint_torques", joint_torques, model.shape_v.size)
            known.update(zip(model.shape_v.tolist(), rates, strict=True))
        v = model.velocity(z, motion, known | self._known(body_velocity), time=time)
        found = model.dynamics(z, v, time=time, motion=motion, torque=torque)
        q = model.coordinates.to_q(z)
        pin.forwardKinematics(model.model, model.data, q, v, found.acceleration)
        frame = model.model.getFrameId(self.tree.base.name)
        whole = pin.getFrameClassicalAcceleration(model.model, model.data, frame, _WORLD).vector
        return Evaluation(
            whole[[0, 1, 5]] if model.planar else np.array(whole),
            found.acceleration[model.shape_v],
            found.torques,
            {k: float(f[0]) if f.size == 1 else f for k, f in found.forces.items()},
            v,
            found.acceleration,
        )

    def simulate(
        self,
        drive: Gait | TorqueLaw | None,
        duration: float,
        *,
        start: str | ArrayLike | None = None,
        pose: ArrayLike | None = None,
        shape: ArrayLike | None = None,
        shape_rates: ArrayLike | None = None,
        passive: Mapping[str, ArrayLike] | None = None,
        sample_interval: float = 0.01,
        rtol: float = 1e-11,
        atol: float = 1e-12,
        max_step: float = 0.25,
        method: str | None = None,
    ) -> History:
        """Simulate.

        Args:
            drive: a gait, which the motors follow; a law torques(t, shape, rates); or None: no
                torque.
            duration: [s].
            start: "impulsive": no momentum along what the constraints leave free; "rest"; or a
                body velocity as in `evaluate`. The machine's own, or impulsive, unless given.
            pose, shape, shape_rates, passive: at the start; a gait gives its own shape.
            sample_interval: [s].
            rtol, atol, max_step: of DOP853.
            method: "kkt", any machine's; or "momentum", the fast form for a lone ball or ellipsoid
                on a plane, which is taken for those unless another is named.

        Raises:
            ConstraintError: the gait passes a singular shape, or the start meets no constraint.
            SimulationError: it had to stop, as where torques bring it to a singular shape:
                `trajectory` holds the rest.
        """
        model = self.model
        gait, law = (drive, None) if isinstance(drive, Gait) else (None, drive)
        if gait is not None:
            model.check_shape(gait.n_legs)
            refuse_singular(model, gait, duration)
        first = None if gait is None else gait(0.0)
        at = first.angle if first is not None else self.shape if shape is None else shape
        z = model.start(self._pose(pose), at if model.motors else None, passive)
        model.check_place(z, first)
        v = self._start(z, start, first, shape_rates)

        def motion(time: float) -> LegMotion | None:
            return None if gait is None else gait(time)

        def torque(time: float, z: Array, v: Array) -> Array | None:
            if law is None:
                return None
            given = law(time, model.shape(z), v[model.shape_v])
            return vector("torques", given, model.shape_v.size)

        def rate(time: float, state: Array) -> Array:
            push = torque(time, *model.split(state))
            return model.rate(time, state, motion(time), push)

        def correct(time: float, state: Array) -> None:
            model.correct(time, state, motion(time))

        times = sample_times(duration, sample_interval)
        stepping = Stepping(None, rtol, atol, max_step)
        begin = np.concatenate((z, v))
        if self._method(method, drive) == "momentum":
            run = roll(self.tree, model, begin, times, stepping)
        else:
            run = integrate(rate, begin, times, stepping, correct=correct)
        history = History(
            name=self.name, tree=self.tree, model=model, time=run.times, states=run.states,
            motion=motion, torque=torque,
        )  # fmt: skip
        if run.stop is not None:
            raise (SimulationInterrupted if run.interrupted else SimulationError)(
                f"the {self.name} stopped at t = {run.time:.6g} s: {run.stop}.",
                time=run.time,
                state=run.state,
                trajectory=history,
            )
        return history

    def simulated(
        self,
        drive: Gait | TorqueLaw | None,
        duration: float,
        sample_interval: float,
        start: str | ArrayLike,
        rtol: float,
        atol: float,
    ) -> History:
        """What `rr.simulate(machine.model, gait, duration)` gives."""
        return self.simulate(
            drive, duration, start=start, sample_interval=sample_interval, rtol=rtol, atol=atol
        )

    def _method(self, method: str | None, drive: object) -> str:
        if method not in (None, "kkt", "momentum"):
            raise ParameterError(f"method is {method!r}: it must be 'kkt' or 'momentum'.")
        alone = drive is None and rolls_alone(self.tree, self.model)
        if method == "momentum" and not alone:
            raise ModelError(
                f"method 'momentum' is for a lone ball or ellipsoid on a plane, and the {self.name}"
                " is none: use 'kkt'."
            )
        return method or ("momentum" if alone else "kkt")

    def _pose(self, pose: ArrayLike | None) -> ArrayLike | None:
        if self.model.planar:
            return self.pose if pose is None else pose
        if pose is None:
            return self.at((0.0, 0.0, 0.0, 1.0)) if self.pose is None else self.pose
        given = np.asarray(pose, dtype=float)
        return self.at(given) if given.shape == (3, 3) else given

    def _known(self, body_velocity: ArrayLike | None) -> dict[int, float]:
        if body_velocity is None:
            return {}
        n = self.model.n_base
        given = np.asarray(body_velocity, dtype=float)
        if n == 6 and given.shape == (3,):
            return dict(zip((3, 4, 5), given.tolist(), strict=True))
        return dict(enumerate(vector("body_velocity", given, n).tolist()))

    def _start(
        self, z: Array, start: str | ArrayLike | None, first: LegMotion | None, rates: object
    ) -> Array:
        model = self.model
        own = self.velocity if first is None else None
        given = own if start is None else start
        known: dict[int, float] = {}
        if first is None:
            size = model.shape_v.size
            values = np.zeros(size) if rates is None else vector("shape_rates", rates, size)  # type: ignore[arg-type]
            known = dict(zip(model.shape_v.tolist(), values.tolist(), strict=True))
        if given is None or (isinstance(given, str) and given == "impulsive"):
            if first is None and any(known.values()):
                still = np.zeros(len(known))
                first = LegMotion(still, np.array(list(known.values())), still)
            return model.impulsive(z, first)
        if isinstance(given, str):
            if given != "rest":
                raise ModelError(
                    f"start is {given!r}: it must be 'impulsive', 'rest' or a body velocity."
                )
            return model.velocity(z, first, known)
        return model.velocity(z, first, known | self._known(given))
