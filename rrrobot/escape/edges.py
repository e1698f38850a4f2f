"""How a flat belly goes on about its edge, and back on its face."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pinocchio as pin

from rrrobot.belly.found import Belly
from rrrobot.belly.placed import with_shell
from rrrobot.checks import Array
from rrrobot.contact.ground import normals
from rrrobot.contact.shells import FlatBelly
from rrrobot.contact.surfaces import Ellipsoid
from rrrobot.drive.gaits import CallableGait, Gait
from rrrobot.errors import SimulationError, SimulationInterrupted
from rrrobot.models.base import Model
from rrrobot.models.full import FullModel
from rrrobot.simulation.events import Event, Snapshot
from rrrobot.simulation.run import simulate
from rrrobot.simulation.trajectory import Trajectory

EDGE = 0.01
"""Least radius of a belly's edge [m]."""
OVER = np.deg2rad((15.0, 30.0, 45.0))
"""Tilts beyond a flat belly's edge at which limbs are to be clear, too [rad]."""
FALL, BACK = 5.0, "back"
"""Longest time that is looked at after the legs have moved [s]; name of the end on the face."""
_SAMPLE = 0.005
_LITTLE, _INSIDE = 1e-3, 1e-6


def until(
    model: Model, drive: Gait, duration: float, events: Sequence[Event], **start: Any
) -> tuple[Trajectory, str]:
    """A run until something ends it, and what that was; empty if nothing did."""
    try:
        run = simulate(model, drive, duration, _SAMPLE, events=events, **start)
    except SimulationInterrupted:
        raise
    except SimulationError as error:
        if error.trajectory is None:
            raise
        return error.trajectory, str(error).partition(". State")[0]
    return run, run.events[-1].name if run.time[-1] < duration * (1 - 1e-9) else ""


def tipped(
    belly: Belly, model: Model, drive: Gait, run: Trajectory, watch: Sequence[Event]
) -> tuple[Trajectory, str]:
    """A run to a flat belly's edge, and how it goes on about that edge."""
    shell, place = belly.shell, place_of(run)
    assert isinstance(shell, FlatBelly)
    across = np.abs(place - belly.center)[:2] / (shell.half_length or np.inf,
                                                 shell.half_width or np.inf)  # fmt: skip
    along = int(np.argmin(across))
    outward = np.zeros(3)
    outward[1 - along] = np.sign((place - belly.center)[1 - along])
    radius = edge_radius(belly, place, outward)
    long = max(radius, (shell.half_length, shell.half_width)[along] or EDGE)
    edge = Ellipsoid((long, radius, radius) if along == 0 else (radius, long, radius))
    robot = with_shell(belly.robot, edge, place + np.array((0.0, 0.0, radius)))

    def beyond(at: Snapshot) -> float:
        """How far its normal at the contact is beyond the flat face's, and a little."""
        normal = normals(at.model.ground, at.position[None])[0]
        return _LITTLE - float(normal @ at.R_world_body @ outward)

    over = FullModel(robot, ground=model.ground, damping=model.damping)
    more, said = until(
        over, _later(drive, float(run.time[-1])), FALL, [*watch, Event(beyond, True, -1, BACK)],
        euler=run.euler[-1], start=run.euler_rates[-1], position=run.position[-1],
    )  # fmt: skip
    return joined(run, more), said


def back_on(
    belly: Belly,
    model: Model,
    drive: Gait,
    run: Trajectory,
    watch: Sequence[Event],
    duration: float,
) -> tuple[Trajectory, str]:
    """How a belly that comes back from its edge goes on, on its flat face."""
    shell, place = belly.shell, (place_of(run) - belly.center)[:2]
    assert isinstance(shell, FlatBelly)
    half = np.array((shell.half_length or np.inf, shell.half_width or np.inf)) - _INSIDE
    return until(
        model, _later(drive, float(run.time[-1])), duration, watch, euler=run.euler[-1],
        start=run.euler_rates[-1], position=np.clip(place, -half, half),
    )  # fmt: skip


def place_of(run: Trajectory) -> Array:
    """Of the contact at the end of a run, in the base's frame (3,) [m]."""
    turn = pin.Quaternion(run.configuration[-1, 3:7].copy()).toRotationMatrix()
    arm = run.ground.point(run.position[-1]) - run.configuration[-1, :3]
    return np.asarray(turn.T @ arm)


def _later(drive: Gait, begun: float) -> CallableGait:
    """A drive from a time on."""

    def later(time: float) -> tuple[Array, Array, Array]:
        motion = drive(begun + time)
        return motion.angle, motion.rate, motion.acceleration

    return CallableGait(later, n_legs=drive.n_legs, check_span=(0.0, 0.1), name="leg_moves")


def joined(run: Trajectory, more: Trajectory) -> Trajectory:
    """A run and how it goes on."""
    arrays: dict[str, Any] = {"time": np.append(run.time, run.time[-1] + more.time[1:])}
    for name, value in vars(run).items():
        after = getattr(more, name)
        if isinstance(value, np.ndarray) and name not in ("time", "state", "memory"):
            arrays[name] = np.concatenate((value, after[1:]))
    # One state stands for all: the model of the flat face has no place for the edge.
    still = np.zeros((len(arrays["time"]), 0))
    return replace(run, state=still, memory=still, end=None, events=more.events, **arrays)


def edge_radius(belly: Belly, place: Array, outward: Array) -> float:
    """Radius of the edge with which it holds what the base has beyond the flat face [m].

    Its support beyond the edge, at angles a from straight down, is radius (1 - cos a).
    """
    radius = EDGE
    points = np.vstack([piece.points for piece in belly.shapes.on_joint(1)]) - place
    for angle in OVER:
        normal = np.sin(angle) * outward - np.array((0.0, 0.0, np.cos(angle)))
        radius = max(radius, float((points @ normal).max()) / (1.0 - np.cos(angle)))
    return radius
