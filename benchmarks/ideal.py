"""How good is the ideal? The same gaits rolled without slip, and in MuJoCo with friction.

Each robot has the belly that `rr.fit_belly` finds, and MuJoCo reads it from `rr.to_mjcf`: the same
bodies, joints and shell, legs on servos, Coulomb friction, soft contact. The gait and the start are
the same. Told are the way of the base's origin and its turn, and by how much MuJoCo's differ.

Run: python -m benchmarks.ideal, which writes docs/ideal.md and docs/images/ideal.png.
"""

from __future__ import annotations

import sys
import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import mujoco
import numpy as np

import rrrobot as rr
from rrrobot.drawing import line, new_figure, tidy, write_figure
from rrrobot.files import write_whole

Array = np.ndarray[Any, Any]
STEP = 0.5e-3
"""Of MuJoCo [s]."""
SAMPLE = 0.01


@dataclass(frozen=True, kw_only=True)
class Case:
    """A robot on its ground with a gait.

    Attributes:
        name: for table and figure.
        robot: a robot, or an example's name.
        ground: what it rolls on.
        amplitude: of the joints that swing [rad].
        joints: which swing: the end of their names.
        phases: by the beginning of their names, in quarters of a turn.
        damping: on the body's rates [N m s/rad].
        tuning: frequency of the gait over that of the roll mode.
        posture: legs [rad]; that of the fit if None.
        cycles: that are run.
    """

    name: str
    robot: Any
    ground: rr.contact.Ground
    amplitude: float
    joints: str
    phases: dict[str, int]
    damping: float
    tuning: float = 0.95
    posture: Any = None
    cycles: int = 12


AHEAD = {"FL": 0, "FR": 2, "HL": 1, "HR": 3, "RL": 1, "RR": 3}
TURN = {"FL": 1, "FR": 0, "HL": 0, "HR": 1, "RL": 0, "RR": 1}
CASES = (
    Case(name="RRRobot, floor", robot=rr.Robot.from_parameters(), ground=rr.Plane(), amplitude=0.3,
         joints="", phases={"leg_1": 0, "leg_2": 1}, damping=0.01, posture=np.pi / 4),
    Case(name="Solo12, dome, floor, ahead", robot="solo12", ground=rr.Plane(), amplitude=0.3,
         joints="HFE", phases=AHEAD, damping=0.05),
    Case(name="Solo12, dome, floor, turn", robot="solo12", ground=rr.Plane(), amplitude=0.3,
         joints="HFE", phases=TURN, damping=0.05),
    Case(name="A1, flat, rock, ahead", robot="a1", ground=rr.Boulder(0.4), amplitude=0.12,
         joints="thigh_joint", phases=AHEAD, damping=0.3),
)  # fmt: skip


class World(NamedTuple):
    """How MuJoCo is set."""

    name: str
    friction: float = 0.6
    servo: float = 60.0
    """bandwidth of the legs' servos [rad/s]"""
    stiff: bool = False
    """contacts four times stiffer in time than MuJoCo's default"""
    pieces: bool = False
    """whether the links' own shapes can touch the ground too"""


WORLDS = (
    World("friction 0.6"),
    World("friction 0.3", friction=0.3),
    World("links' shapes too", pieces=True),
    World("servos five times faster", servo=300.0),
    World("these, and a stiff contact", servo=300.0, stiff=True),
)


class Track(NamedTuple):
    """A motion of the base."""

    time: Array
    place: Array
    """of its origin (n, 3) [m]"""
    yaw: Array
    """(n,) [rad]"""


def prepared(case: Case) -> tuple[rr.belly.Belly, rr.SinusoidalGait, float]:
    """Belly, gait and duration of a case."""
    belly = rr.fit_belly(case.robot, ground=case.ground, posture=case.posture)
    roll = next(m for m in belly.modes if m.axis == "roll" and np.isfinite(m.period))
    legs = belly.robot.legs
    swings = np.array([leg.endswith(case.joints) for leg in legs])
    quarters = [next(q for name, q in case.phases.items() if leg.startswith(name)) for leg in legs]
    omega = case.tuning * 2 * np.pi / roll.period
    gait = rr.SinusoidalGait(
        offset=belly.posture, amplitude=case.amplitude * swings, angular_frequency=omega,
        phase=np.pi / 2 * np.array(quarters),
    )  # fmt: skip
    return belly, gait, case.cycles * 2 * np.pi / omega


def ideal(belly: rr.belly.Belly, gait: rr.Gait, duration: float, damping: float) -> rr.Trajectory:
    """The run without slip."""
    model = belly.model(damping=rr.BodyRateDamping(damping, damping, damping))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)
        return rr.simulate(model, gait, duration, SAMPLE)


def real(
    belly: rr.belly.Belly, gait: rr.Gait, begin: rr.Trajectory, world: World, damping: float
) -> Track:
    """MuJoCo's run from the same start."""
    text = rr.to_mjcf(
        belly.robot, ground=belly.ground, pieces=world.pieces, friction=world.friction,
        servo=world.servo,
    )  # fmt: skip
    model = mujoco.MjModel.from_xml_string(text)
    if world.stiff:
        model.geom_solref[:] = (0.005, 1.0)
    model.opt.timestep = STEP
    # On the three rotations of the free joint.
    model.dof_damping[3:6] = damping
    data = mujoco.MjData(model)
    legs = [model.joint(leg) for leg in belly.robot.legs]
    place = np.array([leg.qposadr[0] for leg in legs])
    speed = np.array([leg.dofadr[0] for leg in legs])
    q, v = begin.configuration[0], begin.velocity[0]
    data.qpos[:3], data.qpos[3:7] = q[:3], q[[6, 3, 4, 5]]
    data.qpos[place] = begin.leg_angle[0]
    turn = np.zeros(9)
    mujoco.mju_quat2Mat(turn, data.qpos[3:7])
    data.qvel[:3], data.qvel[3:6] = turn.reshape(3, 3) @ v[:3], v[3:6]
    data.qvel[speed] = begin.leg_rate[0]
    every = round(SAMPLE / STEP)
    rows = []
    for k in range(len(begin.time) * every):
        if k % every == 0:
            rows.append((data.time, *data.qpos[:7]))
        wanted = gait(data.time)
        data.ctrl[0::2], data.ctrl[1::2] = wanted.angle, wanted.rate
        mujoco.mj_step(model, data)
    table = np.array(rows)
    return Track(table[:, 0], table[:, 1:4], heading(table[:, [5, 6, 7, 4]]))


def heading(quaternions: Array) -> Array:
    """Yaw (n,) [rad] of quaternions (x, y, z, w), without jumps."""
    return np.unwrap(rr.rotations.euler_from_quaternion(quaternions)[:, 2])


def compared(case: Case) -> tuple[Track, dict[str, Track], rr.belly.Feasibility]:
    """The ideal's motion, MuJoCo's in each world, and what the ideal needs."""
    belly, gait, duration = prepared(case)
    t = ideal(belly, gait, duration, case.damping)
    track = Track(t.time, t.configuration[:, :3], heading(t.configuration[:, 3:7]))
    found = rr.belly.feasibility(t, belly=belly)
    return track, {w.name: real(belly, gait, t, w, case.damping) for w in WORLDS}, found


def parted(ours: Track, theirs: Track) -> float:
    """Time at which the paths are a tenth of the ideal's extent apart [s]; infinite if never."""
    n = min(len(ours.time), len(theirs.time))
    extent = np.linalg.norm(np.ptp(ours.place, axis=0))
    apart = np.linalg.norm(ours.place[:n] - theirs.place[:n], axis=1) > 0.1 * extent
    return float(ours.time[np.argmax(apart)]) if apart.any() else np.inf


PAGE = """# How good is the ideal?

Written by `python -m benchmarks.ideal` (extra `bench`). Every model here rolls without slipping,
on rigid ground, with legs that follow their gait exactly. MuJoCo, which reads the same robot and
belly from [`rr.to_mjcf`](reference/bellies.md), has Coulomb friction, soft contacts and servos.
Each run is {cycles} cycles from the same start; compared are the base's origin and its heading.

![Paths of the base, ideal and in MuJoCo](images/ideal.png)

{table}

Why they part:

- Not for friction: the ideal needs less than {friction:.2f} everywhere, and where MuJoCo has only
  0.3 the peaks that need more are too short to move anything far.
- Servos and soft contacts are what differs. Near a rocking mode's resonance a small lag of the
  legs changes the rocking, and with it the way. With servos five times faster and a stiffer
  contact the ends of the paths are at most {apart:.1f} mm apart, the turns {turned:.0f} degrees.
- Parts that stand out of the shell are no part of the ideal. RRRobot's URDF draws bands a
  millimetre proud of its ball: let them touch, and the ball rolls on them. A belly's
  [fit and rolling range](reference/bellies.md) are there to tell.
"""


def main(folder: Path) -> str:
    """The page, as Markdown, into the folder, and the figure into its folder of images."""
    head = (
        "| robot | friction needed | MuJoCo | way, ideal [mm] | way, MuJoCo [mm] "
        "| turn, ideal [deg] | turn, MuJoCo [deg] | ends apart [mm] | parted by a tenth at [s] |"
    )
    rows, most, last, turned = [head, "|---|---|---|---|---|---|---|---|---|"], 0.0, 0.0, 0.0
    figure = new_figure(11.0, 4.0)
    for ax, case in zip(figure.subplots(1, len(CASES)), CASES, strict=True):
        ours, others, found = compared(case)
        most = max(most, found.peak_friction)
        ax.plot(*(1e3 * ours.place[:, :2].T), **line(0), label="ideal")
        for i, (name, theirs) in enumerate(others.items()):
            if name in (WORLDS[0].name, WORLDS[-1].name):
                shown = name if i == 0 else "servos five times faster, stiff contact"
                style = line(1 + (i > 0))
                ax.plot(*(1e3 * theirs.place[:, :2].T), **style, label=f"MuJoCo: {shown}")
            n = min(len(ours.time), len(theirs.time))
            apart = float(1e3 * np.linalg.norm(ours.place[n - 1] - theirs.place[n - 1]))
            last = max(last, apart) if i == len(WORLDS) - 1 else last
            way = [1e3 * np.linalg.norm(t.place[n - 1] - t.place[0]) for t in (ours, theirs)]
            turn = [np.rad2deg(t.yaw[n - 1] - t.yaw[0]) for t in (ours, theirs)]
            turned = max(turned, abs(turn[1] - turn[0])) if i == len(WORLDS) - 1 else turned
            when = parted(ours, theirs)
            rows.append(
                f"| {case.name} | {found.peak_friction:.2f} | {name} | {way[0]:.1f} | {way[1]:.1f} "
                f"| {turn[0]:z.1f} | {turn[1]:z.1f} | {apart:.1f} | "
                f"{'never' if np.isinf(when) else f'{when:.2f}'} |"
            )
        tidy(ax, "x [mm]", "y [mm]")
        ax.set_title(case.name, fontsize=9)
        ax.set_aspect("equal", adjustable="datalim")
    handles, labels = figure.axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=3, frameon=False, fontsize=8)
    write_figure(figure, folder / "images" / "ideal.png")
    numbers = {
        "cycles": CASES[0].cycles,
        "friction": np.ceil(100 * most) / 100,
        "apart": last,
        "turned": turned,
    }
    page = PAGE.format(table="\n".join(rows), **numbers)
    write_whole(folder / "ideal.md", page.encode())
    return page


if __name__ == "__main__":
    print(main(Path(sys.argv[1] if len(sys.argv) > 1 else "docs")))
