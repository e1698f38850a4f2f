"""What is told of a gait: every result's name, unit and meaning, the same wherever it is shown.

A sweep's variables, an optimiser's table, what a simulation confirms and what the command line
prints take their names, units and words from `COLUMNS`. Most are given by the engine, or by a
simulation; those with `of` follow from others, so that another one of that kind is a line here and
nothing elsewhere.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np

from rrrobot.checks import Array

NOT_COMPUTED = -1
"""Status of a gait that a sweep has not reached."""
STATUS = {
    NOT_COMPUTED: "not_computed",
    0: "steady_state",
    1: "pitch_reached_90_degrees",
    2: "value_not_finite",
    3: "lifts_off",
    4: "ground_ends",
    5: "touches_twice",
    6: "orbit_unstable",
    7: "no_orbit_found",
    8: "turns_over",
}
"""What the numbers of the result `status` mean; other results are NaN unless it is 0."""

SETTLED = 0.05
"""Variation from cycle to cycle up to which a motion is said to have settled."""
STILL = 5e-5
"""Step of a cycle below which a body is said to stay where it is; its variation is told over this
instead [m]. What decays still moves a gait that leads nowhere by a hundredth of that."""
_STILL = 1e-9
"""Amplitude up to which an axis has no phase [rad]."""

Given = Mapping[str, Array]
"""Results by name, each (n,)."""


class Column(NamedTuple):
    """One result of a gait."""

    unit: str
    """"1" of a ratio"""
    text: str
    """what it is, in words"""
    of: Callable[[Given], Array] | None = None
    """from the others, in their units; None: it is measured"""
    loads: bool = False
    """whether it needs the forces of the whole robot, which a sweep computes on request"""


def curvature(speed: Array, yaw_rate: Array) -> Array:
    """K = alpha / v [1/m]; infinite for a turn on the spot, zero if nothing moves."""
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        moving = yaw_rate / speed
    still = np.where(np.abs(yaw_rate) > 1e-12, np.copysign(np.inf, yaw_rate), 0.0 * yaw_rate)
    return np.where(speed > 1e-12, moving, still)


def _phase_difference(found: Given) -> Array:
    turn = found["yaw_phase"] - found["pitch_phase"] + np.pi
    swings = (found["pitch_amplitude"] > _STILL) & (found["yaw_amplitude"] > _STILL)
    return np.where(swings, -(turn % (2 * np.pi) - np.pi), np.nan)


COLUMNS: dict[str, Column] = {
    "speed": Column("m/s", "speed v of the contact point from cycle to cycle"),
    "velocity_x": Column("m/s", "velocity along the body's mean forward axis"),
    "velocity_y": Column("m/s", "velocity along the leg axis, positive to the left"),
    "yaw_rate": Column("rad/s", "yaw rate alpha from cycle to cycle"),
    "curvature": Column(
        "1/m",
        "curvature K = alpha / v of the path",
        lambda found: curvature(found["speed"], found["yaw_rate"]),
    ),
    "roll_amplitude": Column("rad", "roll amplitude"),
    "pitch_amplitude": Column("rad", "pitch amplitude"),
    "yaw_amplitude": Column("rad", "yaw amplitude"),
    "roll_phase": Column("rad", "roll phase"),
    "pitch_phase": Column("rad", "pitch phase"),
    "yaw_phase": Column("rad", "yaw phase"),
    "pitch_yaw_phase_difference": Column(
        "rad", "pitch phase less yaw phase, where both swing", _phase_difference
    ),
    "roll_mean": Column("rad", "mean roll"),
    "pitch_mean": Column("rad", "mean pitch"),
    "yaw_mean": Column("rad", "mean yaw"),
    "variation": Column(
        "1", "largest deviation of one cycle's step from the mean step, over the mean length"
    ),
    "normal_force": Column("N", "least normal force of the ground in the last cycle"),
    "pitch": Column("rad", "largest |pitch| from the start on"),
    "tilt": Column(
        "rad", "largest angle of the body's z axis from the ground's normal in the last cycle"
    ),
    "clearance": Column("m", "least distance of any leg to the ground over the last cycle"),
    "peak_torque": Column("N m", "largest |motor torque| of any leg in the last cycle", loads=True),
    "torque_share": Column(
        "1", "largest |motor torque| over what the file allows its joint", loads=True
    ),
    "rms_torque": Column(
        "N m", "root of the mean sum of squared motor torques over the last cycle", loads=True
    ),
    "power": Column("W", "mean sum of |motor torque x leg rate| over the last cycle", loads=True),
    "friction": Column(
        "1", "largest friction coefficient that the contact needs in the last cycle", loads=True
    ),
}
"""All results but the status, in the order in which they are shown.

Amplitudes and phases are of the first harmonic. A leg is where its links' masses are; see
`rrrobot.momentum.heights`. The motors' torques include the damping of their joints; those of a
prismatic leg are forces [N]. Friction is NaN for pivoted models, which have no contact that could
slip; for roll and pitch models it is that of all that holds the body, their guides included.
`torque_share` is 0 where the robot's file limits no effort. Forces, torques, the largest pitch
and tilt are NaN for decoupled models, whose motion no forces of the whole robot make.
"""


def names(*, loads: bool = True) -> tuple[str, ...]:
    """Names of the results, without the loads or with them."""
    return tuple(name for name, column in COLUMNS.items() if loads or not column.loads)


def load_names() -> tuple[str, ...]:
    """Names of the loads alone."""
    return tuple(name for name, column in COLUMNS.items() if column.loads)


def completed(found: Given, *, loads: bool = True) -> dict[str, Array]:
    """The measured results with those that follow from them, in order, and the status."""
    whole = dict(found)
    for name in names(loads=loads):
        rule = COLUMNS[name].of
        if rule is not None:
            whole[name] = rule(whole)
    return {name: whole[name] for name in (*names(loads=loads), "status")}
