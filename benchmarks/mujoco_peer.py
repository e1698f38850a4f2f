"""RRRobot in MuJoCo: a sphere on a plane, legs that follow the gait, threaded rollouts.

The robot is the same: five point masses, the shell a massless sphere whose contact carries it.

Legs. MuJoCo cannot prescribe a joint's motion within a rollout, so each leg joint gets an armature,
driven by armature times the wanted acceleration. An armature adds to the diagonal of the mass
matrix only and does not react on the body, so this is the prescribed motion up to (leg torque /
armature). A rollout is one cycle, and the legs are put back onto the gait before the next. They
stay within 1e-5 rad of it, closer than servos do. The armature is no larger because the contact
solver loses its digits at 1e6 kg m^2: a rocking robot then gains energy.

Damping. On the Euler rates, as in the paper: the base is three slides and the hinges yaw, pitch,
roll, each hinge with a joint damping. On the body rates: a free joint with the damping of its three
rotations. Both are MuJoCo's own joint damping.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any, NamedTuple

import mujoco
import numpy as np
from mujoco.rollout import Rollout

import rrrobot as rr
from benchmarks.common import (
    AMPLITUDE,
    COUNTED,
    CYCLES,
    KAPPA,
    OMEGA,
    PERIOD,
    Array,
    Motion,
    Plane,
    Timing,
    impulsive_rates,
    motion_of_means,
)

ARMATURE = 1e4
"""[kg m^2]"""
SLIDES = "".join(f"<joint type='slide' axis='{a}'/>" for a in ("1 0 0", "0 1 0", "0 0 1"))
HINGES = "".join(f"<joint type='hinge' axis='{a}'/>" for a in ("0 0 1", "0 1 0", "1 0 0"))
NO_SLIP = "cone='elliptic' impratio='100' noslip_iterations='10' solver='Newton'"
GRIP = "friction='10 0.005 0.0001'"
STIFF = "solref='0.002 1' solimp='0.99 0.999 0.0001'"


@dataclass(frozen=True, kw_only=True)
class Settings:
    """How MuJoCo is set.

    Attributes:
        name: for the tables.
        steps: time steps in a cycle; 786 are 1.0 ms.
        option: attributes of MJCF's <option>.
        contact: attributes of both geoms.
        free_joint: a free joint damped on the body rates, or slides and hinges damped on the
            Euler rates.
        thin: every how many-th row and column of the sweep is run.
    """

    name: str
    steps: int = 786
    option: str = ""
    contact: str = ""
    free_joint: bool = False
    thin: int = 1


CASES = (
    Settings(name="defaults, 2 ms", steps=393),
    Settings(name="no-slip settings, 1 ms", option=NO_SLIP, contact=GRIP),
    Settings(name="no-slip settings, 1 ms, condim 4", option=NO_SLIP,
             contact=f"{GRIP} condim='4'", thin=2),
    Settings(name="no-slip settings, 4 ms", steps=196, option=NO_SLIP, contact=GRIP),
    Settings(name="no-slip and stiff contact, 1 ms", option=NO_SLIP, contact=f"{GRIP} {STIFF}"),
    Settings(name="no-slip and stiff contact, RK4, 1 ms", option=f"{NO_SLIP} integrator='RK4'",
             contact=f"{GRIP} {STIFF}", thin=4),
    Settings(name="no-slip settings, 1 ms", option=NO_SLIP, contact=GRIP, free_joint=True, thin=2),
    Settings(name="no-slip and stiff contact, RK4, 1 ms", option=f"{NO_SLIP} integrator='RK4'",
             contact=f"{GRIP} {STIFF}", free_joint=True, thin=4),
)  # fmt: skip


def mjcf(settings: Settings) -> str:
    """The robot as MJCF."""
    p = rr.RRRobotParameters()
    r, b, leg = p.shell_radius, p.hip_offset, p.leg_lengths[0]
    battery, servo, tip = p.battery_mass, p.servo_masses[0], p.leg_masses[0]
    mass = battery + 2 * servo
    z = -battery * r / mass
    low = battery * r**2 - mass * z**2
    inertia = f"{low + 2 * servo * b**2!r} {low!r} {2 * servo * b**2!r}"
    legs = "".join(
        f"<body pos='0 {y!r} 0'><joint name='{name}' type='hinge' axis='0 -1 0' "
        f"armature='{ARMATURE!r}'/><inertial pos='{leg!r} 0 0' mass='{tip!r}' "
        "diaginertia='1e-12 1e-12 1e-12'/></body>"
        for name, y in (("leg_1", -b), ("leg_2", b))
    )
    motors = "".join(f"<motor joint='{n}' gear='{ARMATURE!r}'/>" for n in ("leg_1", "leg_2"))
    base = "<freejoint/>" if settings.free_joint else SLIDES + HINGES
    return (
        "<mujoco><compiler angle='radian'/>"
        f"<option timestep='{PERIOD / settings.steps!r}' gravity='0 0 {-p.gravity!r}' "
        f"{settings.option}/><worldbody>"
        f"<geom type='plane' size='0 0 1' {settings.contact}/>"
        f"<body pos='0 0 {r!r}'>{base}"
        f"<inertial pos='0 0 {z!r}' mass='{mass!r}' diaginertia='{inertia}'/>"
        f"<geom type='sphere' size='{r!r}' mass='0' {settings.contact}/>{legs}"
        f"</body></worldbody><actuator>{motors}</actuator></mujoco>"
    )


def load(settings: Settings, damping: float = KAPPA) -> mujoco.MjModel:
    """The compiled model, with damping on the body's three rotations [N m s/rad]."""
    model = mujoco.MjModel.from_xml_string(mjcf(settings))
    model.dof_damping[3:6] = damping
    return model


def _legs(plane: Plane, times: Array) -> tuple[Array, Array]:
    """Leg angles and rates (n, times, 2)."""
    phase = np.column_stack((np.zeros_like(plane.phase), plane.phase))
    turn = OMEGA * times[None, :, None] + phase[:, None]
    angle = plane.offset[:, None, None] + AMPLITUDE * np.sin(turn)
    return angle, AMPLITUDE * OMEGA * np.cos(turn)


def _drive(plane: Plane, model: mujoco.MjModel, steps: int) -> tuple[Array, Array, Array]:
    """Leg accelerations of a cycle's steps (n, steps, 2), and angle and rate at its start.

    They are such that the integrator's own sums pass through the gait at every step.
    """
    h = model.opt.timestep
    angle, rate = _legs(plane, h * np.arange(-1, steps + 1))
    if model.opt.integrator == mujoco.mjtIntegrator.mjINT_RK4:
        return np.diff(rate[:, 1:], axis=1) / h, angle[:, 1], rate[:, 1]
    second = (angle[:, 2:] - 2 * angle[:, 1:-1] + angle[:, :-2]) / h**2
    return second, angle[:, 1], (angle[:, 1] - angle[:, 0]) / h


def _start(plane: Plane, model: mujoco.MjModel, angle: Array, rate: Array) -> Array:
    """States (n, state) of the upright impulsive start."""
    free = model.nq > model.nv
    omega = impulsive_rates(plane)
    full = mujoco.mjtState.mjSTATE_FULLPHYSICS
    state = np.zeros((plane.offset.size, mujoco.mj_stateSize(model, full)))
    q, v = state[:, 1 : 1 + model.nq], state[:, 1 + model.nq : 1 + model.nq + model.nv]
    q[:] = model.qpos0
    q[:, -2:], v[:, -2:] = angle, rate
    v[:, :3] = rr.RRRobotParameters().shell_radius * np.cross(omega, (0.0, 0.0, 1.0))
    v[:, 3:6] = omega if free else omega[:, ::-1]
    return state


def _places(states: Array, model: mujoco.MjModel) -> Array:
    """x, y and yaw (..., 3) of states."""
    q = states[..., 1 : 1 + model.nq]
    if model.nq == model.nv:
        return q[..., (0, 1, 3)]
    w, x, y, z = np.moveaxis(q[..., 3:7], -1, 0)
    yaw = np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
    return np.stack((q[..., 0], q[..., 1], yaw), axis=-1)


class Run(NamedTuple):
    """A sweep by MuJoCo."""

    motion: Motion
    timing: Timing
    """of all cycles, from the median cycle"""
    total: Timing
    """as it was"""
    leg_error: float
    """largest distance of a leg from its gait at the end of a cycle [rad]"""


def sweep(
    settings: Settings, plane: Plane, *, threads: int, cycles: int = CYCLES, counted: int = COUNTED
) -> Run:
    """Roll the plane's gaits out, cycle by cycle, and take the cycle means."""
    model, steps = load(settings), settings.steps
    control, angle, rate = _drive(plane, model, steps)
    state = _start(plane, model, angle, rate)
    states = np.empty((len(state), steps, state.shape[1]))
    data = [mujoco.MjData(model) for _ in range(max(1, threads))]
    means, timings, leg_error = [], [], 0.0
    legs = slice(1 + model.nq - 2, 1 + model.nq)
    last = _places(state, model)
    with Rollout(nthread=threads if threads > 1 else 0) as pool:
        for cycle in range(cycles):
            clock = time.perf_counter(), time.process_time()
            pool.rollout(model, data, state, control, state=states)
            timings.append((time.perf_counter() - clock[0], time.process_time() - clock[1]))
            state = states[:, -1].copy()
            leg_error = max(leg_error, float(np.abs(state[:, legs] - angle).max()))
            state[:, legs], state[:, model.nq + model.nv - 1 : model.nq + model.nv + 1] = (
                angle,
                rate,
            )
            if cycle >= cycles - counted - 1:
                places = np.concatenate((last[:, None], _places(states, model)), axis=1)
                places[..., 2] = np.unwrap(places[..., 2], axis=1)
                last = places[:, -1]
                means.append((places.sum(axis=1) - 0.5 * (places[:, 0] + last)) / steps)
    typical = np.median(timings, axis=0) * cycles
    return Run(
        motion_of_means(np.array(means[-counted:])),
        Timing(*typical.tolist()),
        Timing(*np.sum(timings, axis=0).tolist()),
        leg_error,
    )


def rocking_loss(
    settings: Settings, axis: str, *, tilt: float = 0.3, duration: float = 30.0
) -> float:
    """Share of the energy that a free rocking without damping loses; from its amplitudes.

    Args:
        settings: of MuJoCo; not with a free joint.
        axis: "roll" or "pitch".
        tilt: angle from which the robot is let go, legs straight up [rad].
        duration: of the rocking [s].
    """
    model = load(settings, damping=0.0)
    steps = round(duration / model.opt.timestep)
    full = mujoco.mjtState.mjSTATE_FULLPHYSICS
    state = np.zeros((1, mujoco.mj_stateSize(model, full)))
    column = 1 + {"pitch": 4, "roll": 5}[axis]
    state[0, column] = tilt
    state[0, 1 + model.nq - 2 : 1 + model.nq] = np.pi / 2
    with Rollout(nthread=0) as pool:
        states, _ = pool.rollout(
            model, mujoco.MjData(model), state, np.zeros((1, 1, 2)), nstep=steps
        )
    # One full swing takes 1.3 s at most.
    last = np.abs(states[0, -round(1.5 / model.opt.timestep) :, column]).max()
    return float(1 - (1 - np.cos(last)) / (1 - np.cos(tilt)))


def describe(settings: Settings) -> dict[str, Any]:
    """The settings as plain data."""
    return {
        "time_step_ms": 1e3 * PERIOD / settings.steps,
        "option": settings.option or "defaults",
        "contact": settings.contact or "defaults",
    }
