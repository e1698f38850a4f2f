"""RRRobot in Drake: compliant contact of a sphere with a half space, stepped by its solvers.

Drake has no constraint for rolling without slip; its documentation recommends discrete steps with
the SAP solver, whose friction holds up to a regularisation. The base is three slides and hinges for
yaw, pitch and roll, whose joint damping is the paper's. Each leg has a rotor inertia (which Drake
adds to the diagonal of the mass matrix and does not let react on the body), driven by that inertia
times the wanted acceleration, so that the legs follow the gait whatever the body does.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from benchmarks.peer_job import Array, Job, answer, motion, timed

BASE = ("x", "y", "z", "yaw", "pitch", "roll")
LEGS = ("leg_1", "leg_2")
FRICTION = 10.0
"""Of ball and ground: enough that nothing slides."""
ROTOR = 1e7
"""Inertia of each leg's rotor [kg m^2]."""


def plant_of(job: Job, builder: Any) -> Any:
    """The robot on its plane, finalised, in a diagram builder."""
    from pydrake.geometry import HalfSpace, Sphere
    from pydrake.math import RigidTransform
    from pydrake.multibody.plant import AddMultibodyPlant, MultibodyPlantConfig

    s = job.settings
    names = {
        "discrete_contact_approximation": "approximation",
        "contact_model": "contact_model",
        "stiction_tolerance": "stiction",
    }
    chosen = {name: s[key] for name, key in names.items() if key in s}
    step = job.step if s.get("discrete", True) else 0.0
    plant, _ = AddMultibodyPlant(MultibodyPlantConfig(time_step=step, **chosen), builder)
    plant.mutable_gravity_field().set_gravity_vector((0, 0, -job.gravity))
    base = add_base(job, plant)
    add_legs(job, plant, base)
    for body, shape, name in (
        (base, Sphere(job.radius), "ball"),
        (plant.world_body(), HalfSpace(), "ground"),
    ):
        properties = properties_of(job, name)
        plant.RegisterCollisionGeometry(body, RigidTransform(), shape, name, properties)
    plant.Finalize()
    return plant


def properties_of(job: Job, name: str) -> Any:
    """Material of the ball or the ground; what the job does not set is Drake's default."""
    from pydrake.geometry import (
        AddCompliantHydroelasticPropertiesForHalfSpace,
        AddContactMaterial,
        AddRigidHydroelasticProperties,
        ProximityProperties,
    )
    from pydrake.multibody.plant import CoulombFriction

    s, properties = job.settings, ProximityProperties()
    AddContactMaterial(
        dissipation=s.get("dissipation"),
        point_stiffness=s.get("stiffness"),
        friction=CoulombFriction(FRICTION, FRICTION),
        properties=properties,
    )
    if name == "ground" and "modulus" in s:
        AddCompliantHydroelasticPropertiesForHalfSpace(0.1, s["modulus"], properties)
    if name == "ball" and "resolution" in s:
        AddRigidHydroelasticProperties(s["resolution"], properties)
    return properties


def add_base(job: Job, plant: Any) -> Any:
    """Slides x, y, z and hinges yaw, pitch, roll; the last link is the body, which is returned."""
    from pydrake.multibody.tree import PrismaticJoint, RevoluteJoint, SpatialInertia, UnitInertia

    mass, z, inertia = job.body()
    about_centre = inertia / mass + np.array((z * z, z * z, 0.0))
    hull = SpatialInertia(mass=mass, p_PScm_E=(0, 0, z), G_SP_E=UnitInertia(*about_centre))
    # A link between two joints; one integrator refuses it without mass.
    bead = SpatialInertia.SolidSphereWithMass(1e-9, 1e-3)
    parent = plant.world_frame()
    for name, axis in zip(BASE, np.vstack((np.eye(3), np.eye(3)[::-1])), strict=True):
        link = plant.AddRigidBody(name, hull if name == "roll" else bead)
        if len(name) == 1:
            joint = PrismaticJoint(name, parent, link.body_frame(), axis)
        else:
            joint = RevoluteJoint(name, parent, link.body_frame(), axis, job.damping)
        plant.AddJoint(joint)
        parent = link.body_frame()
    return link


def add_legs(job: Job, plant: Any, base: Any) -> None:
    """Both legs with their motors."""
    from pydrake.math import RigidTransform
    from pydrake.multibody.tree import (
        FixedOffsetFrame,
        RevoluteJoint,
        SpatialInertia,
        UnitInertia,
    )

    point = UnitInertia(0.0, job.leg**2, job.leg**2)
    for name, y in zip(LEGS, (-job.radius, job.radius), strict=True):
        leg = plant.AddRigidBody(name, SpatialInertia(job.tip, (job.leg, 0.0, 0.0), point))
        at = RigidTransform((0.0, y, 0.0))
        hip = plant.AddFrame(FixedOffsetFrame(f"hip of {name}", base.body_frame(), at))
        joint = plant.AddJoint(RevoluteJoint(name, hip, leg.body_frame(), (0, -1, 0)))
        motor = plant.AddJointActuator(name, joint)
        motor.set_default_rotor_inertia(ROTOR)
        motor.set_default_gear_ratio(1.0)


def drive_legs(job: Job, plant: Any, builder: Any, summed: bool) -> None:
    """Torques of the motors: the rotor's inertia times the gait's acceleration."""
    from pydrake.systems.primitives import Gain, Sine

    size = job.amplitude * (job.summed_acceleration() if summed else 1.0)
    phases = np.array((0.0, job.phase))
    sine = builder.AddSystem(Sine(np.full(2, size), np.full(2, job.omega), phases))
    torque = builder.AddSystem(Gain(ROTOR, 2))
    builder.Connect(sine.get_output_port(2), torque.get_input_port())
    if "servo" in job.settings:
        # Steps of a varying length do not sum to the gait: feedback, in units of the rotor.
        servo_legs(builder, plant, sine, torque, job, job.settings["servo"])
    else:
        builder.Connect(torque.get_output_port(), plant.get_actuation_input_port())


def servo_legs(builder: Any, plant: Any, sine: Any, ahead: Any, job: Job, speed: float) -> None:
    """Critically damped feedback of the legs' angles and rates, of the angular frequency speed."""
    from pydrake.systems.controllers import PidController
    from pydrake.systems.primitives import Adder, ConstantVectorSource, Multiplexer

    states = plant.num_multibody_states()
    joints = [plant.GetJointByName(f"leg_{k}") for k in (1, 2)]
    choose = np.zeros((4, states))
    for k, joint in enumerate(joints):
        choose[k, joint.position_start()] = 1.0
        choose[2 + k, plant.num_positions() + joint.velocity_start()] = 1.0
    gains = np.full(2, ROTOR * speed**2), np.zeros(2), np.full(2, 2 * ROTOR * speed)
    pid = builder.AddSystem(PidController(choose, np.eye(2), *gains))
    builder.Connect(plant.get_state_output_port(), pid.get_input_port_estimated_state())
    middle = builder.AddSystem(ConstantVectorSource(np.full(2, job.offset)))
    angle, want = builder.AddSystem(Adder(2, 2)), builder.AddSystem(Multiplexer([2, 2]))
    builder.Connect(sine.get_output_port(0), angle.get_input_port(0))
    builder.Connect(middle.get_output_port(), angle.get_input_port(1))
    builder.Connect(angle.get_output_port(), want.get_input_port(0))
    builder.Connect(sine.get_output_port(1), want.get_input_port(1))
    builder.Connect(want.get_output_port(0), pid.get_input_port_desired_state())
    both = builder.AddSystem(Adder(2, 2))
    builder.Connect(pid.get_output_port(), both.get_input_port(0))
    builder.Connect(ahead.get_output_port(), both.get_input_port(1))
    builder.Connect(both.get_output_port(), plant.get_actuation_input_port())


def set_start(job: Job, plant: Any, context: Any, summed: bool) -> None:
    """The impulsive start, upright, the ball as deep in the ground as its weight wants."""
    angle, rate, _ = job.legs(0.0)
    if summed:
        rate = (angle - job.legs(-job.step)[0]) / job.step
    stiffness = job.settings.get("stiffness")
    sunk = job.mass * job.gravity / stiffness if stiffness else 0.0
    positions = (0.0, 0.0, job.radius - sunk, 0.0, 0.0, 0.0, *angle)
    speeds = (*job.centre_start(), *job.start[::-1], *rate)
    for name, position, speed in zip(BASE + LEGS, positions, speeds, strict=True):
        joint = plant.GetJointByName(name)
        if len(name) == 1:
            joint.set_translation(context, position)
            joint.set_translation_rate(context, speed)
        else:
            joint.set_angle(context, position)
            joint.set_angular_rate(context, speed)


def simulate(job: Job) -> dict[str, Any]:
    """The gait's speed, yaw rate, times, and how far legs and height strayed."""
    from pydrake.systems.analysis import ApplySimulatorConfig, Simulator, SimulatorConfig
    from pydrake.systems.framework import DiagramBuilder
    from pydrake.systems.primitives import LogVectorOutput

    s, builder = job.settings, DiagramBuilder()
    plant = plant_of(job, builder)
    summed = s.get("discrete", True) or not s.get("error_control", True)
    drive_legs(job, plant, builder, summed)
    interval, wanted = job.period / s["samples"], job.cycles * s["samples"] + 1
    log = LogVectorOutput(plant.get_state_output_port(), builder, interval)
    simulator = Simulator(builder.Build())
    if "integrator" in s:
        config = SimulatorConfig(
            integration_scheme=s["integrator"],
            max_step_size=job.step,
            accuracy=s.get("accuracy", 1e-3),
            use_error_control=s.get("error_control", True),
        )
        ApplySimulatorConfig(config, simulator)
    context = simulator.get_mutable_context()
    set_start(job, plant, plant.GetMyMutableContextFromRoot(context), summed)
    simulator.Initialize()
    # A little longer, lest rounding leaves the last sample out.
    _, times = timed(lambda: simulator.AdvanceTo((wanted - 1) * interval + 0.1 * job.step))
    record = log.FindLog(context)
    t = record.sample_times()
    fresh = np.flatnonzero(np.concatenate(([True], np.diff(t) > 1e-9)))[:wanted]
    order = [plant.GetJointByName(name).position_start() for name in BASE + LEGS]
    states: Array = record.data()[order][:, fresh].T
    return {
        **motion(states[:, (0, 1, 3)], job),
        **times,
        "leg_error": float(np.abs(states[-1, 6:] - job.legs(t[fresh[-1]])[0]).max()),
        "height": [float(f(states[:, 2])) for f in (np.min, np.max)],
    }


if __name__ == "__main__":
    answer(simulate, "drake")
