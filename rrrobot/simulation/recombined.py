"""`decoupled`: a run of the single-axis models, recombined by rolling."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from rrrobot.drive.gaits import Gait, LegMotion
from rrrobot.errors import GaitError
from rrrobot.integrate import sample_times
from rrrobot.models.recombined import NEEDS_GAIT, DecoupledModels
from rrrobot.models.single_axis import PitchModel, RollModel, YawModel
from rrrobot.progress import Progress
from rrrobot.robot.robot import Robot
from rrrobot.simulation.evaluate import trajectory_of
from rrrobot.simulation.flow import Flow
from rrrobot.simulation.run import raise_if_stopped
from rrrobot.simulation.trajectory import Trajectory
from rrrobot.simulation.watch import watch


class _Apart(Gait):
    """A gait of all models and one of the yaw model's own, side by side."""

    def __init__(self, gait: Gait, yaw: Gait) -> None:
        self.gait, self.yaw = gait, yaw
        self.n_legs = gait.n_legs + yaw.n_legs
        self.period = gait.period

    def __call__(self, time: ArrayLike) -> LegMotion:
        parts = zip(self.gait(time), self.yaw(time), strict=True)
        return LegMotion(*(np.concatenate(pair, axis=-1) for pair in parts))

    def to_dict(self) -> dict[str, Any]:
        return {"type": "apart", "gait": self.gait.to_dict(), "yaw": self.yaw.to_dict()}


def decoupled(
    robot: Robot,
    gait: Gait,
    duration: float = 30.0,
    sample_interval: float = 0.01,
    *,
    yaw_gait: Gait | None = None,
    roll: RollModel | None = None,
    pitch: PitchModel | None = None,
    yaw: YawModel | None = None,
    start: str | ArrayLike = "impulsive",
    euler: ArrayLike = (0.0, 0.0, 0.0),
    step: float | None = None,
    rtol: float | None = None,
    atol: float | None = None,
    progress: Progress = False,
) -> Trajectory:
    """Simulate the single-axis models and superpose them into one rolling motion.

    theta(t) = (roll, pitch, yaw) of the three models; the contact
    point follows by eqs (2)-(3).

    The motion does not obey the full equations. Its `contact_force` and `leg_torque` are what they
    demand of it (Pinocchio's inverse dynamics of the whole robot along it), `energy` is the whole
    robot's, and metadata["unbalanced_moment"] is the largest moment about the contact point [N m]
    that nothing supplies: zero for the full model, here the size of what decoupling neglects.

    Args:
        robot: with a spherical shell about the root link's origin, on level ground.
        gait: leg motion.
        duration, sample_interval: [s].
        yaw_gait: leg motion of the yaw model alone, such as the gait with the amplitude that
            `matching_yaw_amplitude` gives (the paper's Fig 20); `gait` if None.
        roll, pitch, yaw: the models, with other dampings than the paper's.
        start, euler: as for `simulate`.
        step, rtol, atol, progress: as for `simulate`.

    Raises:
        ModelError, GaitError, ParameterError, SimulationError: as for `simulate`.

    Example:
        >>> import rrrobot as rr
        >>> robot = rr.Robot.from_parameters()
        >>> rr.decoupled(robot, rr.gait("lateral"), duration=2.0)
        Trajectory(decoupled model of rrrobot, 201 samples, 0 .. 2 s, contact travelled 30.3 cm)
    """
    if not isinstance(gait, Gait) or not isinstance(yaw_gait, Gait | None):
        raise GaitError(NEEDS_GAIT)
    model = DecoupledModels(robot, roll, pitch, yaw)
    own = yaw_gait or gait
    for each in (gait, own):
        model.roll.check_legs(each.n_legs)
    periods = [each.period / 12 for each in (gait, own) if each.period is not None]
    longest = min([*(part.max_step for part in (model.roll, model.pitch)), *periods])
    drive = gait if yaw_gait is None else _Apart(gait, own)
    times = sample_times(duration, sample_interval)
    flow = Flow(model, drive, step=step, rtol=rtol, atol=atol, max_step=longest)
    begin = flow.start(start=start, euler=euler)
    found = flow.evolve(0.0, times[-1], begin, samples=times, progress=progress)
    settings = {"evaluations": found.run.evaluations} | flow.stepping.to_dict()
    trajectory = trajectory_of(flow, found, settings)
    gaits = {"gait": gait.to_dict(), "yaw_gait": own.to_dict()}
    trajectory = replace(trajectory, metadata={**trajectory.metadata, **gaits})
    raise_if_stopped(flow, found, trajectory)
    watch(trajectory)
    return trajectory
