"""The result of a simulation."""

from __future__ import annotations

import io
import json
import warnings
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from rrrobot.checks import Array
from rrrobot.contact.ground import Ground, normals
from rrrobot.contact.saved import ground_from_dict
from rrrobot.drive.laws import Memory
from rrrobot.errors import ModelError, OutputError, UnsettledWarning
from rrrobot.files import read_bytes, write_whole
from rrrobot.inline import html_table, percent
from rrrobot.robot.robot import Robot
from rrrobot.simulation import export, saved
from rrrobot.simulation.events import Hit
from rrrobot.simulation.state import State
from rrrobot.simulation.steady import SteadyState, steady_state

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

FORMAT = "rrrobot trajectory 2"


@dataclass(frozen=True, kw_only=True, eq=False)
class Trajectory:
    """A robot's motion: arrays of n samples, SI units, and what made them.

    Attributes:
        time: (n,) [s], from 0 to the duration, both ends.
        euler: roll, pitch, yaw without jumps (n, 3) [rad].
        euler_rates: (n, 3) [rad/s].
        position: contact point in the ground plane (n, 2) [m].
        leg_angle, leg_rate: (n, legs) [rad, rad/s].
        contact_force: of the ground (or the pivot) on the robot, world frame (n, 3) [N].
        leg_torque: motor torques (n, legs) [N m]; forces [N] for prismatic joints.
        energy: kinetic plus potential (n,) [J].
        slip: speed of the shell's material point at the contact (n,) [m/s].
        height_error: distance of the shell's lowest point from the ground (n,) [m].
        configuration: free-flyer q of `robot.model` (n, nq), for the viewer and for Pinocchio.
        velocity: free-flyer v of `robot.model` (n, nv).
        state: the model's own state vector (n, ny).
        memory: what the drive remembers (n, k); k = 0 for one that does not.
        events: those that were found, in order of time.
        end: the end of the run, with what its drive hides and the engine's own variables; None
            once it is loaded. Use `final_state`.
        robot: the robot.
        ground: what it rolls on; `position` is in its coordinates.
        metadata: model, gait or torques, integrator, versions; plain data.

    Example:
        >>> import rrrobot as rr
        >>> model = rr.FullModel(rr.Robot.from_parameters())
        >>> rr.simulate(model, rr.gait("lateral"), duration=2.0)
        Trajectory(full model of rrrobot, 201 samples, 0 .. 2 s, contact travelled 30.4 cm)
    """

    time: Array
    euler: Array
    euler_rates: Array
    position: Array
    leg_angle: Array
    leg_rate: Array
    contact_force: Array
    leg_torque: Array
    energy: Array
    slip: Array
    height_error: Array
    configuration: Array
    velocity: Array
    state: Array
    robot: Robot = field(repr=False)
    ground: Ground = field(repr=False)
    metadata: Mapping[str, Any] = field(default_factory=dict, repr=False)
    memory: Array = field(default_factory=lambda: np.empty((0, 0)), repr=False)
    events: tuple[Hit, ...] = field(default=(), repr=False)
    end: State | None = field(default=None, repr=False)

    def __post_init__(self) -> None:
        if not self.memory.size:
            object.__setattr__(self, "memory", np.empty((len(self.time), 0)))

    @property
    def final_state(self) -> State:
        """The end, from which `simulate(..., state=)` goes on."""
        return self.state_at(-1) if self.end is None else self.end

    def state_at(self, sample: int) -> State:
        """State at a sample, from which `simulate(..., state=)` goes on.

        Example:
            >>> import rrrobot as rr
            >>> model = rr.FullModel(rr.Robot.from_parameters())
            >>> t = rr.simulate(model, rr.gait("lateral"), duration=2.0)
            >>> t.state_at(50)
            State(full model of rrrobot at 0.5 s)
        """
        cut = self.metadata.get("integration", {}).get("continuous_memory")
        row = self.memory[sample].copy()
        return State(
            model=dict(self.metadata["model"]),
            robot=self.robot,
            time=float(self.time[sample]),
            vector=self.state[sample].copy(),
            euler=self.euler[sample].copy(),
            memory=None if cut is None else Memory(row[:cut], row[cut:]),
            drive=self.metadata.get("gait"),
        )

    @property
    def model_name(self) -> str:
        """Name of the model that made it."""
        return str(self.metadata.get("model", {}).get("type", "unknown"))

    @property
    def period(self) -> float | None:
        """Period of the gait [s], if it has one."""
        return self.metadata.get("period")

    @property
    def has_contact(self) -> bool:
        """Whether `contact_force` is a rolling contact's, and not a pivot's."""
        return bool(self.metadata.get("has_contact", True))

    @property
    def gravity(self) -> float:
        """g that acted [m/s^2]."""
        return self.robot.gravity if self.ground.gravity is None else self.ground.gravity

    @property
    def ground_normal(self) -> Array:
        """Unit normal of the ground at the contact point (n, 3)."""
        return normals(self.ground, self.position)

    @property
    def tilt(self) -> Array:
        """Angle of the body's z axis from the ground's normal (n,), roll and pitch together [rad].

        Example:
            >>> import rrrobot as rr
            >>> model = rr.FullModel(rr.Robot.from_parameters())
            >>> t = rr.simulate(model, rr.gait("lateral"), duration=2.0)
            >>> bool((t.tilt >= abs(t.euler[:, 1]) - 1e-9).all())
            True
        """
        (sr, sp, sy), (cr, cp, cy) = np.sin(self.euler.T), np.cos(self.euler.T)
        up = np.column_stack((cy * sp * cr + sy * sr, sy * sp * cr - cy * sr, cp * cr))
        across = np.linalg.norm(np.cross(up, self.ground_normal), axis=1)
        return np.asarray(np.arctan2(across, np.sum(up * self.ground_normal, axis=1)))

    @property
    def normal_force(self) -> Array:
        """Contact force along the ground's normal (n,) [N]."""
        fixed = self.ground.fixed_normal
        if fixed is not None:
            return self.contact_force @ fixed
        return np.sum(self.contact_force * self.ground_normal, axis=1)

    @property
    def required_friction(self) -> Array:
        """Friction coefficient that the contact needs not to slip, |F_t| / F_n (n,).

        Infinite where the normal force is not positive: no friction would do.

        Raises:
            ModelError: the model has no rolling contact.
        """
        if not self.has_contact:
            raise ModelError(
                f"the {self.model_name} model is pivoted: it has no contact that could slip."
            )
        normal = self.normal_force
        tangent = self.contact_force - normal[:, None] * self.ground_normal
        size = np.linalg.norm(tangent, axis=1)
        return np.divide(size, normal, out=np.full_like(size, np.inf), where=normal > 0)

    @property
    def lift_off_time(self) -> float | None:
        """First sample at which the normal force is not positive [s], or None.

        From then on the real robot would leave the ground, and this motion means nothing.
        """
        lifted = np.flatnonzero(self.normal_force <= 0) if self.has_contact else np.empty(0, int)
        return float(self.time[lifted[0]]) if lifted.size else None

    def steady_state(
        self, *, after: float | None = None, period: float | None = None
    ) -> SteadyState:
        """Cycle means and amplitudes of the settled motion; see `rrrobot.simulation.steady`.

        Args:
            after: time from which whole cycles are counted [s]; half the duration by default.
            period: of the cycle [s]; the gait's by default.

        Warns:
            UnsettledWarning: single cycles differ by more than 5 %, `SteadyState.settled`.

        Example:
            >>> import rrrobot as rr
            >>> model = rr.FullModel(rr.Robot.from_parameters())
            >>> t = rr.simulate(model, rr.gait("circular"), duration=30.0)
            >>> round(t.steady_state().speed, 5)
            0.00668
        """
        state = steady_state(self, after=after, period=period)
        if not state.settled:
            warnings.warn(
                f"the motion has not settled: over the {state.cycles} cycles from "
                f"{state.after:.4g} s on, the velocity of single cycles is up to "
                f"{percent(state.variation)} from the mean. Simulate longer, or find the limit "
                "cycle (limit_cycle).",
                UnsettledWarning,
                stacklevel=2,
            )
        return state

    def plot(self, kind: str = "all", ax: Any = None) -> Any:
        """Plot "angles", "path", "energy", "force" or "legs" on `ax`, or "all" in one figure.

        Returns:
            the Axes, or the Figure for "all".
        """
        from rrrobot.simulation.plots import plot

        return plot(self, kind, ax)

    def save(self, path: str | Path) -> Path:
        """Write everything to one .npz file, whole or not at all; `load` is the inverse.

        Raises:
            OutputError: the file cannot be written.
        """
        target = Path(path)
        if target.suffix != ".npz":
            raise OutputError(f"cannot write {str(target)!r}: a trajectory's file ends in .npz.")
        header = {
            "format": FORMAT,
            "robot": self.robot.to_dict(),
            "ground": self.ground.to_dict(),
            "metadata": dict(self.metadata),
        }
        try:
            text = json.dumps(header)
        except (TypeError, ValueError) as error:
            raise OutputError(
                f"cannot write {str(target)!r}: the metadata is not plain data: {error}."
            ) from None
        buffer = io.BytesIO()
        arrays = {name: getattr(self, name) for name in _ARRAYS}
        np.savez_compressed(buffer, header=np.array(text), **arrays)
        return write_whole(target, buffer.getvalue())

    def to_dataset(self) -> xr.Dataset:
        """An xarray.Dataset with units, frames and descriptions; see `simulation.export`."""
        return export.to_dataset(self)

    def to_pandas(self) -> pd.DataFrame:
        """A pandas.DataFrame over the time [s]; `attrs["units"]` has each column's unit."""
        return export.to_pandas(self)

    def to_csv(self, path: str | Path) -> Path:
        """Write the columns of `to_pandas`, headed "name [unit]", to a .csv file.

        Raises:
            OutputError: the file cannot be written, or its name does not end in .csv.
        """
        return export.to_csv(self, path)

    def to_mat(self, path: str | Path) -> Path:
        """Write every array, with structs of units and descriptions, to a MATLAB .mat file.

        Raises:
            OutputError: the file cannot be written, or its name does not end in .mat.
        """
        return export.to_mat(self, path)

    @classmethod
    def load(cls, path: str | Path) -> Trajectory:
        """Read what `save` wrote.

        Raises:
            OutputError: the file is missing, damaged, or not a trajectory.
        """
        try:
            header, arrays = saved.unpacked(read_bytes(path), _ARRAYS)
            if header["format"] != FORMAT:
                raise ValueError(
                    f"its format is {header['format']!r}, and this version reads {FORMAT!r}"
                )
            robot = Robot.from_dict(header["robot"])
            saved.check_arrays(arrays, robot)
            ground = ground_from_dict(header["ground"])
            metadata = saved.checked_metadata(header["metadata"])
            return cls(robot=robot, ground=ground, metadata=metadata, **arrays)
        except FileNotFoundError:
            raise OutputError(f"there is no file {str(path)!r}: check the path.") from None
        except Exception as error:  # a damaged archive raises almost anything
            reason = str(error).rstrip(".") or type(error).__name__
            raise OutputError(
                f"{str(path)!r} is not a trajectory that rrrobot saved: {reason}."
            ) from error

    def _repr_html_(self) -> str:
        return html_table(repr(self), {}, figure=self.plot("all"))

    def __len__(self) -> int:
        return len(self.time)

    def __repr__(self) -> str:
        step = np.linalg.norm(np.diff(self.position, axis=0), axis=1).sum()
        parts = [
            f"{self.model_name} model of {self.robot.name}",
            f"{len(self)} samples",
            f"{self.time[0]:g} .. {self.time[-1]:g} s",
            f"contact travelled {100 * step:.3g} cm",
        ]
        if self.lift_off_time is not None:
            parts.append(f"LIFTS OFF at {self.lift_off_time:.4g} s")
        return f"Trajectory({', '.join(parts)})"


_OTHERS = ("robot", "ground", "metadata", "events", "end")
_ARRAYS = tuple(f.name for f in fields(Trajectory) if f.name not in _OTHERS)
