"""What a model answers: where its body is, its accelerations and forces, its equations' terms."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from rrrobot.checks import Array
from rrrobot.contact.touching import Contact


class Placement(NamedTuple):
    """A pose in every model's terms; made once per evaluation by `Model.place`."""

    quaternion: Array
    """(x, y, z, w) of R_world_body, unit (4,)"""
    position: Array
    """contact point in the ground's coordinates (2,) [m]"""
    rotation: Array
    """R_world_body (3, 3)"""
    configuration: Array
    """the body's part of Pinocchio's q, which comes first (body nq,)"""
    basis: Array
    """the body's part of Pinocchio's v per unit of quasi-velocity (body nv, n_quasi)"""
    contact: Contact | None = None
    """where the shell touches the ground, where the pose says so"""


class Dynamics(NamedTuple):
    """One evaluation of a model's equations of motion."""

    acceleration: Array
    """a (nv,) in the model's Pinocchio coordinates"""
    contact_force: Array
    """force of the ground, or of the pivot, on the robot in the world frame (3,) [N]"""
    leg_torque: Array
    """motor torques (legs,) [N m]; forces [N] for prismatic joints"""
    q: Array
    """Pinocchio's configuration (nq,)"""
    v: Array
    """Pinocchio's velocity (nv,)"""
    forces: Mapping[str, Array]
    """of each constraint, by its name; "legs" are the motors of prescribed legs"""
    residuals: Mapping[str, Array]
    """velocities by which each constraint's rows are missed, by its name"""


class Equations(NamedTuple):
    """Terms of M a + C v + G = tau + J^T f in a model's Pinocchio coordinates."""

    mass_matrix: Array
    """M(q) (nv, nv)"""
    coriolis: Array
    """C(q, v) (nv, nv); M_dot - 2 C is skew-symmetric"""
    gravity: Array
    """G(q) (nv,)"""
