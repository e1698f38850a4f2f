"""RRRobot in Jiminy: its sphere that rolls without slipping, an exact constraint.

`SphereConstraint` gives Jacobian and drift of the rolling sphere; `JointConstraint` holds each leg
to the acceleration of the gait (its reference is set, in continuous time, so that its correction
equals the wanted acceleration). Alternatively, the sphere rests on the ground by its contact model.
The damping of the Euler rates is a torque of the internal dynamics.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from benchmarks.peer_job import (
    Array,
    Job,
    answer,
    euler_of_quaternions,
    motion,
    timed,
)

STIFF = 40 * np.pi
"""Angular frequency of the feedback that keeps the legs at the gait [rad/s]."""


def urdf(job: Job) -> str:
    """The robot as URDF, its root free."""
    mass, z, inertia = job.body()

    def inertial(mass: float, x: float, z: float, diagonal: Array) -> str:
        ixx, iyy, izz = (repr(float(i)) for i in diagonal)
        return (
            f"<inertial><origin xyz='{x!r} 0 {z!r}'/><mass value='{mass!r}'/><inertia ixx='{ixx}' "
            f"iyy='{iyy}' izz='{izz}' ixy='0' ixz='0' iyz='0'/></inertial>"
        )

    ball = f"<collision><geometry><sphere radius='{job.radius!r}'/></geometry></collision>"
    parts = [f"<link name='body'>{inertial(mass, 0.0, z, inertia)}{ball}</link>"]
    for number, y in ((1, -job.radius), (2, job.radius)):
        parts.append(
            f"<link name='tip_{number}'>{inertial(job.tip, job.leg, 0.0, np.zeros(3))}</link>"
            f"<joint name='leg_{number}' type='revolute'><parent link='body'/>"
            f"<child link='tip_{number}'/><origin xyz='0 {y!r} 0'/><axis xyz='0 -1 0'/>"
            "<limit lower='-10' upper='10' effort='1e9' velocity='1e9'/></joint>"
        )
    return f"<robot name='rrrobot'>{''.join(parts)}</robot>"


def euler_torque(
    x: float, y: float, z: float, w: float, p: float, q: float, r: float
) -> tuple[float, float, float]:
    """Torque on the body, in its frame, of a unit damping on each Euler rate.

    Minus W^T W omega, where (roll', pitch', yaw') = W omega: quaternion x, y, z, w; omega p, q, r.
    """
    s_pitch = 2 * (w * y - z * x)
    c_pitch = math.sqrt(1 - s_pitch * s_pitch)
    s_roll, c_roll = 2 * (w * x + y * z) / c_pitch, (1 - 2 * (x * x + y * y)) / c_pitch
    pitch, yaw = c_roll * q - s_roll * r, (s_roll * q + c_roll * r) / c_pitch
    roll = p + s_pitch * yaw
    turn = (s_pitch * roll + yaw) / c_pitch
    return -roll, -c_roll * pitch - s_roll * turn, s_roll * pitch - c_roll * turn


def robot_of(job: Job) -> tuple[Any, list[Any]]:
    """The robot on its ground, and the constraints of its legs."""
    import tempfile
    from pathlib import Path

    import jiminy_py.core as jiminy

    robot = jiminy.Robot("rrrobot")
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "rrrobot.robot.urdf"
        path.write_text(urdf(job))
        robot.initialize(str(path), has_freeflyer=True)
    if job.settings.get("contact") == "ground":
        robot.add_collision_bodies(["body"], ignore_meshes=False)
    else:
        sphere = jiminy.SphereConstraint("body", job.radius)
        robot.add_constraint("rolling", sphere)
        sphere.baumgarte_freq = job.settings.get("baumgarte", 20.0)
    legs = []
    for number in (1, 2):
        leg = jiminy.JointConstraint(f"leg_{number}")
        robot.add_constraint(f"leg_{number}", leg)
        leg.kp, leg.kd = STIFF**2, 2 * STIFF
        legs.append(leg)
    return robot, legs


def controller_of(job: Job, legs: list[Any]) -> Any:
    """Moves the legs' references, and damps the Euler rates."""
    import jiminy_py.core as jiminy

    sin, cos = math.sin, math.cos
    size, speed, k = job.amplitude, job.omega, job.damping
    moved = tuple(zip(legs, (0.0, job.phase), strict=True))

    def command(t: float, q: Array, v: Array, _sensors: Any, out: Array) -> None:
        for leg, phase in moved:
            turn = speed * t + phase
            # The constraint's own feedback, kp (q - reference) + kd v, is minus the acceleration.
            ahead = (1 - speed**2 / STIFF**2) * sin(turn) + 2 * speed / STIFF * cos(turn)
            leg.reference_configuration = np.array((job.offset + size * ahead,))

    def damping(t: float, q: Array, v: Array, _sensors: Any, out: Array) -> None:
        x, y, z = euler_torque(*q[3:7].tolist(), *v[3:6].tolist())
        out[3:6] = k * x, k * y, k * z

    return jiminy.FunctionalController(command, damping)


def engine_of(job: Job, robot: Any) -> Any:
    """The engine with the job's settings and its own defaults; it keeps no log."""
    import jiminy_py.core as jiminy

    s, engine = job.settings, jiminy.Engine()
    engine.add_robot(robot)
    options = engine.get_options()
    stepper, solver = options["stepper"], options["constraints"]
    stepper["dtMax"] = job.step
    stepper["odeSolver"] = s.get("solver", stepper["odeSolver"])
    stepper["tolAbs"] = s.get("tol_abs", stepper["tolAbs"])
    stepper["tolRel"] = s.get("tol_rel", stepper["tolRel"])
    solver["regularization"] = s.get("regularization", solver["regularization"])
    options["contacts"].update(s.get("contacts", {}))
    options["telemetry"] = dict.fromkeys(options["telemetry"], False)
    engine.set_options(options)
    return engine


def simulate(job: Job) -> dict[str, Any]:
    """The gait's speed, yaw rate, times, and how far legs and height strayed."""
    robot, legs = robot_of(job)
    robot.controller = controller_of(job, legs)
    engine = engine_of(job, robot)
    angle, rate, _ = job.legs(0.0)
    q = np.concatenate(((0.0, 0.0, job.radius, 0.0, 0.0, 0.0, 1.0), angle))
    v = np.concatenate((job.centre_start(), job.start, rate))
    interval = job.period / job.settings["samples"]
    states = np.empty((job.cycles * job.settings["samples"] + 1, len(q)))

    def march() -> None:
        engine.start(q, v)
        states[0] = engine.robot_states[0].q
        for i in range(1, len(states)):
            engine.step(i * interval - engine.stepper_state.t)
            states[i] = engine.robot_states[0].q
        engine.stop()

    _, times = timed(march)
    yaw = euler_of_quaternions(states[:, 3:7])[:, 2]
    angle, _, _ = job.legs(job.cycles * job.period)
    return {
        **motion(np.column_stack((states[:, :2], yaw)), job),
        **times,
        "leg_error": float(np.abs(states[-1, 7:] - angle).max()),
        "height": [float(f(states[:, 2])) for f in (np.min, np.max)],
    }


if __name__ == "__main__":
    answer(simulate, "jiminy-py")
