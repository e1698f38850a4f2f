"""What a machine did: samples of its pose, shape, velocities, forces and energy."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import pinocchio as pin

from rrrobot.checks import Array
from rrrobot.drive.gaits import LegMotion
from rrrobot.inline import html_table
from rrrobot.machines.mechanism import MachineDynamics, Mechanism
from rrrobot.machines.tree import Tree


@dataclass(frozen=True, eq=False, kw_only=True)
class History:
    """A machine's motion at n times.

    Forces, energy and violation are computed when they are first asked for.

    Attributes:
        name: of the machine; `tree`: its links and joints; `model`: its equations.
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
        gap: the largest that positions are off on holonomic rows (n,) [m or rad].
        states: coordinates and velocity (n, nz + nv).
        motion: what the motors follow, (time) -> LegMotion or None.
        torque: what they push with, (time, z, v) -> (shape,) or None.

    Example:
        >>> import rrrobot as rr
        >>> sleigh = rr.machines.chaplygin_sleigh()
        >>> t = sleigh.simulate(None, 2.0, start=(0.4, 0.0, 1.3))
        >>> t.pose.shape, float(abs(t.energy - t.energy[0]).max()) < 1e-11
        ((201, 3), True)
    """

    name: str
    tree: Tree
    model: Mechanism
    time: Array
    states: Array
    motion: Callable[[float], LegMotion | None]
    torque: Callable[[float, Array, Array], Array | None]

    def __repr__(self) -> str:
        end = f"{self.time[0]:g} .. {self.time[-1]:.4g} s"
        return f"History({self.name}, {len(self)} samples, {end})"

    def _repr_html_(self) -> str:
        rows = {
            "time": f"{self.time[0]:g} .. {self.time[-1]:.4g} s, {len(self)} samples",
            "pose at the end": self.pose[-1].round(4).tolist(),
            "energy": f"{self.energy.min():.4g} .. {self.energy.max():.4g} J",
            "constraints broken by": f"{self.violation.max():.1e}",
        }
        return html_table(f"Motion of the {self.name}", rows)

    @property
    def velocity(self) -> Array:
        return self.states[:, self.model.coordinates.size :]

    @property
    def pose(self) -> Array:
        return self.states[:, : 3 if self.model.planar else 7]

    @property
    def quaternion(self) -> Array:
        if not self.model.planar:
            return self.pose[:, 3:]
        half = 0.5 * self.pose[:, 2]
        zero = np.zeros_like(half)
        return np.stack((zero, zero, np.sin(half), np.cos(half)), axis=1)

    @property
    def shape(self) -> Array:
        return self.model.shape(self.states)

    @property
    def shape_rates(self) -> Array:
        return self.velocity[:, self.model.shape_v]

    @property
    def body_velocity(self) -> Array:
        return self.velocity[:, : self.model.n_base]

    @cached_property
    def _solved(self) -> list[MachineDynamics]:
        return [
            self.model.dynamics(z, v, time=t, motion=self.motion(t), torque=self.torque(t, z, v))
            for t, z, v in self._split()
        ]

    @cached_property
    def joint_torques(self) -> Array:
        return np.array([found.torques for found in self._solved])

    @cached_property
    def multipliers(self) -> dict[str, Array]:
        forces = [found.forces for found in self._solved]
        return {
            name: np.array([f[name] for f in forces]).reshape(
                len(forces), *(() if first.size == 1 else (-1,))
            )
            for name, first in forces[0].items()
        }

    @cached_property
    def energy(self) -> Array:
        return np.array([self.model.energy(z, v) for _, z, v in self._split()])

    @cached_property
    def violation(self) -> Array:
        model, found = self.model, []
        for t, z, v in self._split():
            rows = model.rows(model.coordinates.to_q(z), v, t, self.motion(t))
            found.append(np.abs(rows.residual).max(initial=0.0))
        return np.array(found)

    @cached_property
    def gap(self) -> Array:
        model, found = self.model, []
        for t, z, v in self._split():
            q, motion = model.coordinates.to_q(z), self.motion(t)
            model.rows(q, v, t, motion)
            found.append(np.abs(model.gaps(q, v, t, motion)).max(initial=0.0))
        return np.array(found)

    def _split(self) -> Iterator[tuple[float, Array, Array]]:
        for t, state in zip(self.time.tolist(), self.states, strict=True):
            yield t, *self.model.split(state)

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
            "machine": self.name,
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
