"""What a machine did: samples of its pose, shape, velocities, forces and energy."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import pinocchio as pin

from rrrobot.checks import Array
from rrrobot.drive.gaits import LegMotion

if TYPE_CHECKING:
    from rrrobot.machines.machine import Machine


@dataclass(frozen=True, eq=False, kw_only=True)
class History:
    """A machine's motion at n times.

    Attributes:
        time: (n,) [s].
        pose: (x, y, theta) (n, 3) in the plane, theta counting full turns; position and quaternion
            (x, y, z, w) (n, 7) in space.
        quaternion: of the base (n, 4), continuous; right however often it turns over.
        shape, shape_rates: of the motors (n, shape).
        body_velocity: of the base in its own axes, (n, 3) or (n, 6).
        velocity: of all joints (n, nv), Pinocchio's.
        joint_torques: (n, shape) [N m].
        multipliers: force of each constraint by its name, (n,) or (n, rows).
        energy: kinetic and potential (n,) [J].
        violation: the largest of |J v - c| over all rows (n,).
        states: coordinates and velocity (n, nz + nv).
        machine: whose motion it is.

    Example:
        >>> import rrrobot as rr
        >>> sleigh = rr.machines.chaplygin_sleigh()
        >>> t = sleigh.simulate(None, 2.0, start=(0.4, 0.0, 1.3))
        >>> t.pose.shape, float(abs(t.energy - t.energy[0]).max()) < 1e-11
        ((201, 3), True)
    """

    time: Array
    pose: Array
    quaternion: Array
    shape: Array
    shape_rates: Array
    body_velocity: Array
    velocity: Array
    joint_torques: Array
    multipliers: dict[str, Array]
    energy: Array
    violation: Array
    states: Array
    machine: Machine

    @classmethod
    def of(
        cls,
        machine: Machine,
        time: Array,
        states: Array,
        motion: Callable[[float], LegMotion | None],
        torque: Callable[[float, Array, Array], Array | None],
    ) -> History:
        """From states (n, nz + nv) and what drove them."""
        model = machine.model
        forces: list[dict[str, Array]] = []
        torques, energy, violation = [], [], []
        for t, state in zip(time.tolist(), states, strict=True):
            z, v = model.split(state)
            moved = motion(t)
            found = model.dynamics(z, v, time=t, motion=moved, torque=torque(t, z, v))
            forces.append(found.forces)
            torques.append(found.torques)
            energy.append(model.energy(z, v))
            rows = model.rows(model.coordinates.to_q(z), v, t, moved)
            violation.append(np.abs(rows.residual).max(initial=0.0))
        cut = model.coordinates.size
        v = states[:, cut:]
        pose = states[:, : 3 if model.planar else 7]
        if model.planar:
            half = 0.5 * pose[:, 2]
            zero = np.zeros_like(half)
            quaternion = np.stack((zero, zero, np.sin(half), np.cos(half)), axis=1)
        else:
            quaternion = pose[:, 3:]
        multipliers = {
            name: np.squeeze(np.array([f[name] for f in forces]), axis=1)
            if forces[0][name].size == 1
            else np.array([f[name] for f in forces])
            for name in forces[0]
        }
        return cls(
            time=time, pose=pose, quaternion=quaternion, shape=model.shape(states),
            shape_rates=v[:, model.shape_v], body_velocity=v[:, : model.n_base], velocity=v,
            joint_torques=np.array(torques), multipliers=multipliers, energy=np.array(energy),
            violation=np.array(violation), states=states, machine=machine,
        )  # fmt: skip

    def __len__(self) -> int:
        return int(self.time.size)

    @property
    def rotation_vector(self) -> Array:
        """Of each orientation, of the least angle (n, 3) [rad]."""
        return np.array([pin.log3(pin.Quaternion(q).toRotationMatrix()) for q in self.quaternion])

    @property
    def wheel_angles(self) -> Array:
        """(yaw, lean, spin) of R = Rz(yaw) Rx(lean) Ry(spin) (n, 3) [rad].

        For what turns over about its y axis: singular only where it lies flat, lean = +-90 degrees.
        """
        found = np.empty((len(self), 3))
        for i, q in enumerate(self.quaternion):
            r = pin.Quaternion(q).toRotationMatrix()
            lean = np.arcsin(np.clip(r[2, 1], -1.0, 1.0))
            found[i] = (np.arctan2(-r[0, 1], r[1, 1]), lean, np.arctan2(-r[2, 0], r[2, 2]))
        return np.unwrap(found, axis=0)

    def to_dict(self) -> dict[str, Any]:
        """Plain data: the name, the end, and what is kept."""
        return {
            "machine": self.machine.name,
            "duration": float(self.time[-1]),
            "samples": len(self),
            "pose": self.pose[-1].tolist(),
            "shape": self.shape[-1].tolist(),
            "body_velocity": self.body_velocity[-1].tolist(),
            "energy": {
                "start": float(self.energy[0]),
                "end": float(self.energy[-1]),
                "min": float(self.energy.min()),
                "max": float(self.energy.max()),
            },
            "violation": float(self.violation.max()),
        }
