"""RRRobot in Pinocchio alone, as a user's own loop would have it; symplectic Euler steps.

Pinocchio has no rolling constraint. What it offers is `CONTACT_3D` at a point that is fixed to the
body, so a loop puts that point below the centre before every step. The acceleration that this asks
for is the body point's, not the rolling contact's: the centre accelerates by what keeps a body
point still, and sinks, unless a Baumgarte correction holds it. The other loop writes the Jacobian
of rolling, without its drift, and repairs the velocity of the centre after every step. Each leg is
held to the gait by an armature (which does not react on the body), or by a row of its own.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from benchmarks.peer_job import (
    Array,
    Job,
    answer,
    euler_of_quaternions,
    euler_rates_map,
    motion,
    timed,
)  # fmt: skip

Acceleration = Callable[[float, Array, Array], Array]
"""Of time, configuration and velocity."""

ARMATURE = 1e7
"""Of each leg joint, where an armature holds it to the gait [kg m^2]."""


def model_of(job: Job) -> Any:
    """The robot: a free-flyer root, two leg joints about -y."""
    import pinocchio as pin

    model = pin.Model()
    model.gravity.linear = np.array((0.0, 0.0, -job.gravity))
    root = model.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), "root")
    mass, z, inertia = job.body()
    model.appendBodyToJoint(
        root, pin.Inertia(mass, np.array((0.0, 0.0, z)), np.diag(inertia)), pin.SE3.Identity()
    )
    for name, y in (("leg_1", -job.radius), ("leg_2", job.radius)):
        place = pin.SE3(np.eye(3), np.array((0.0, y, 0.0)))
        axis = pin.JointModelRevoluteUnaligned(np.array((0.0, -1.0, 0.0)))
        leg = model.addJoint(root, axis, place, name)
        tip = pin.Inertia(job.tip, np.array((job.leg, 0.0, 0.0)), np.zeros((3, 3)))
        model.appendBodyToJoint(leg, tip, pin.SE3.Identity())
    return model


def damping_torque(job: Job, rotation: Array, v: Array) -> Array:
    """Generalised force (8,) of the damping of the Euler rates."""
    yaw = np.arctan2(rotation[1, 0], rotation[0, 0])
    rates_map = np.linalg.solve(euler_rates_map(-np.arcsin(rotation[2, 0]), yaw), rotation)
    tau = np.zeros(8)
    tau[3:6] = -job.damping * rates_map.T @ (rates_map @ v[3:6])
    return tau


def rotation_of(q: Array) -> Array:
    """R of a configuration (3, 3)."""
    import pinocchio as pin

    return pin.Quaternion(q[3:7]).toRotationMatrix()


def by_contact(job: Job) -> Acceleration:
    """Accelerations by `constraintDynamics`, the contact put below the centre each time."""
    import pinocchio as pin

    model = model_of(job)
    model.armature = np.concatenate((np.zeros(6), np.full(2, ARMATURE)))
    here = pin.SE3.Identity()
    aligned = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
    contact = pin.RigidConstraintModel(pin.ContactType.CONTACT_3D, model, 1, here, 0, here, aligned)
    speed = job.settings.get("frequency", 0.0)
    contact.setBaumgarteCorrectorParameters(pin.BaumgarteCorrectorParameters(speed**2, 2 * speed))
    contacts, contact_data = pin.StdVec_RigidConstraintModel(), pin.StdVec_RigidConstraintData()
    contacts.append(contact)
    contact_data.append(contacts[0].createData())
    data = model.createData()
    pin.initConstraintDynamics(model, data, contacts, contact_data)
    summed = job.summed_acceleration()

    def acceleration(t: float, q: Array, v: Array) -> Array:
        rotation = rotation_of(q)
        contacts[0].joint1_placement = pin.SE3(np.eye(3), -job.radius * rotation[2])
        contacts[0].joint2_placement = pin.SE3(np.eye(3), np.array((q[0], q[1], 0.0)))
        tau = damping_torque(job, rotation, v)
        tau[6:] = ARMATURE * summed * job.legs(t)[2]
        return pin.constraintDynamics(model, data, q, v, tau, contacts, contact_data)

    return acceleration


def by_rows(job: Job) -> Acceleration:
    """Accelerations by `forwardDynamics` with the rows of rolling and of the legs."""
    import pinocchio as pin

    model = model_of(job)
    data = model.createData()
    aligned = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
    summed, legs = job.summed_acceleration(), np.eye(8)[6:]

    def acceleration(t: float, q: Array, v: Array) -> Array:
        rotation, drift = rotation_of(q), np.zeros(3)
        rows = np.vstack((jacobian(model, data, q, job.radius), legs))
        if job.settings["method"] == "rolling drift":
            pin.forwardKinematics(model, data, q, v, np.zeros(8))
            # The centre's own; the angular part is zero with a free flyer as root.
            drift = pin.getClassicalAcceleration(model, data, 1, aligned).linear
        gamma = np.concatenate((drift, -summed * job.legs(t)[2]))
        tau = damping_torque(job, rotation, v)
        return pin.forwardDynamics(model, data, q, v, tau, rows, gamma, 0.0)

    return acceleration


def jacobian(model: Any, data: Any, q: Array, radius: float) -> Array:
    """Rows (3, 8) of the velocity of the ball's lowest point."""
    import pinocchio as pin

    frame, rotation = pin.computeJointJacobian(model, data, q, 1), rotation_of(q)
    return rotation @ frame[:3] + pin.skew(np.array((0.0, 0.0, radius))) @ rotation @ frame[3:]


def overwritten(job: Job, q: Array, v: Array) -> Array:
    """The velocity with the centre's part that rolls."""
    rotation = rotation_of(q)
    centre = job.radius * np.cross(rotation @ v[3:6], (0.0, 0.0, 1.0))
    return np.concatenate((rotation.T @ centre, v[3:]))


def simulate(job: Job) -> dict[str, Any]:
    """The gait's speed, yaw rate, times, and how far legs and height strayed."""
    import pinocchio as pin

    model, h, steps = model_of(job), job.step, job.steps * job.cycles
    acceleration = (by_contact if job.settings["method"] == "CONTACT_3D" else by_rows)(job)
    angle = job.legs(0.0)[0]
    start = np.concatenate(((0.0, 0.0, job.radius, 0.0, 0.0, 0.0, 1.0), angle))
    rates = np.concatenate((job.centre_start(), job.start, (angle - job.legs(-h)[0]) / h))
    states = np.empty((steps + 1, len(start)))

    def march(q: Array, v: Array) -> None:
        states[0] = q
        for i in range(steps):
            v = v + h * acceleration(i * h, q, v)
            q = pin.integrate(model, q, h * v)
            if job.settings.get("project") == "overwrite":
                v = overwritten(job, q, v)
            states[i + 1] = q

    _, times = timed(lambda: march(start, rates))
    yaw = euler_of_quaternions(states[:, 3:7])[:, 2]
    return {
        **motion(np.column_stack((states[:, :2], yaw)), job),
        **times,
        "leg_error": float(np.abs(states[-1, 7:] - job.legs(steps * h)[0]).max()),
        "height": [float(f(states[:, 2])) for f in (np.min, np.max)],
    }


if __name__ == "__main__":
    answer(simulate, "pin")
