"""RRRobot in Exudyn: a kinematic tree with rolling as a velocity constraint, or penalty contact.

Exudyn's joints roll discs, not spheres, so the rolling of a sphere is written as a user function of
`CoordinateVectorConstraint` on the velocities of the tree; `CoordinateConstraint` prescribes height
and legs. Alternatively, a sphere rests on two triangles by `ObjectContactSphereTriangle`, which is
a penalty contact with friction. The damping of the Euler rates is the tree's own.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Sequence
from typing import Any

import numpy as np

from benchmarks.peer_job import Job, answer, motion, timed

FRICTION = 10.0
"""Of ball and ground: enough that nothing slides."""


def rolling_jacobian(q: Sequence[float], radius: float) -> list[list[float]]:
    """J (2, 8) of J q' = 0: slip of the sphere's lowest point along x and y."""
    c, s = radius * math.cos(q[3]), radius * math.sin(q[3])
    cp = math.cos(q[4])
    return [
        [1.0, 0.0, 0.0, 0.0, -c, -s * cp, 0.0, 0.0],
        [0.0, 1.0, 0.0, 0.0, -s, c * cp, 0.0, 0.0],
    ]


def slip(q: Sequence[float], v: Sequence[float], radius: float) -> list[float]:
    """J q', (2,) [m/s]."""
    return [sum(map(operator.mul, row, v)) for row in rolling_jacobian(q, radius)]


def tree_of(job: Job, mbs: Any, sunk: float) -> tuple[int, int]:
    """Node and object of the robot: three slides, yaw, pitch and roll, two legs."""
    import exudyn as exu
    import exudyn.itemInterface

    items, kinds = exudyn.itemInterface, exu.JointType
    angle, rate, _ = job.legs(0.0)
    mass, z, inertia = job.body()
    roll, pitch, yaw = job.start
    node = mbs.AddNode(
        items.NodeGenericODE2(
            numberOfODE2Coordinates=8, referenceCoordinates=[0.0] * 8,
            initialCoordinates=[0.0, 0.0, job.radius - sunk, 0.0, 0.0, 0.0, *angle],
            initialCoordinates_t=[*job.centre_start(), yaw, pitch, roll, *rate],
        )
    )  # fmt: skip
    types = [
        kinds.PrismaticX, kinds.PrismaticY, kinds.PrismaticZ,
        kinds.RevoluteZ, kinds.RevoluteY, kinds.RevoluteX, kinds.RevoluteY, kinds.RevoluteY,
    ]  # fmt: skip
    # A leg's frame is turned about x, so that its joint's axis is the body's -y.
    flip, nothing, none = np.diag((1.0, -1.0, -1.0)), np.zeros((3, 3)), np.zeros(3)
    side, tip = np.array((0.0, job.radius, 0.0)), np.array((job.leg, 0.0, 0.0))
    tree = mbs.AddObject(
        items.ObjectKinematicTree(
            nodeNumber=node, gravity=[0.0, 0.0, -job.gravity], jointTypes=types,
            linkParents=[-1, 0, 1, 2, 3, 4, 5, 5],
            jointTransformations=exu.Matrix3DList([np.eye(3)] * 6 + [flip] * 2),
            jointOffsets=exu.Vector3DList([none] * 6 + [-side, side]),
            linkInertiasCOM=exu.Matrix3DList([nothing] * 5 + [np.diag(inertia)] + [nothing] * 2),
            linkCOMs=exu.Vector3DList([none] * 5 + [np.array((0.0, 0.0, z))] + [tip] * 2),
            linkMasses=[0.0] * 5 + [mass, job.tip, job.tip],
            jointPositionOffsetVector=[0.0] * 8, jointVelocityOffsetVector=[0.0] * 8,
            jointPControlVector=[0.0] * 8,
            jointDControlVector=[0.0] * 3 + [job.damping] * 3 + [0.0] * 2,
        )
    )  # fmt: skip
    return node, tree


def add_legs(job: Job, mbs: Any, node: int, fixed: int) -> None:
    """Both leg angles follow the gait."""
    import exudyn.itemInterface

    items = exudyn.itemInterface
    a, w = job.amplitude, job.omega
    for k, phase in enumerate((0.0, job.phase)):
        marker = mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=node, coordinate=6 + k))
        mbs.AddObject(
            items.CoordinateConstraint(
                markerNumbers=[fixed, marker],
                offsetUserFunction=lambda _m, t, _i, _o, p=phase: (
                    job.offset + a * math.sin(w * t + p)
                ),
                offsetUserFunction_t=lambda _m, t, _i, _o, p=phase: a * w * math.cos(w * t + p),
            )
        )


def add_contact(job: Job, mbs: Any, tree: int, sunk: float) -> None:
    """Penalty contact of the ball with a triangle that is wide enough."""
    import exudyn as exu
    import exudyn.itemInterface

    items, s, far = exudyn.itemInterface, job.settings, 1e3
    ground = mbs.AddObject(items.ObjectGround())
    ball = mbs.AddMarker(items.MarkerKinematicTreeRigid(objectNumber=tree, linkNumber=5))
    floor = mbs.AddMarker(items.MarkerBodyRigid(bodyNumber=ground))
    data = mbs.AddNode(
        items.NodeGenericData(initialCoordinates=[-sunk, 0.0, 0.0, 0.0], numberOfDataCoordinates=4)
    )
    mbs.AddObject(
        items.ObjectContactSphereTriangle(
            markerNumbers=[ball, floor], nodeNumber=data, sphereRadius=job.radius,
            trianglePoints=exu.Vector3DList([[-far, -far, 0.0], [far, -far, 0.0], [0.0, far, 0.0]]),
            includeEdges=0, dynamicFriction=FRICTION, frictionProportionalZone=s["stiction"],
            contactStiffness=s["stiffness"], contactDamping=s["dissipation"],
        )
    )  # fmt: skip


def add_rolling(job: Job, mbs: Any, node: int, nowhere: int, fixed: int) -> None:
    """The centre's height is held, and the lowest point has no velocity."""
    import exudyn.itemInterface

    items, r = exudyn.itemInterface, job.radius
    height = mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=node, coordinate=2))
    mbs.AddObject(items.CoordinateConstraint(markerNumbers=[fixed, height], offset=r))
    whole = mbs.AddMarker(items.MarkerNodeCoordinates(nodeNumber=node))
    void = mbs.AddMarker(items.MarkerNodeCoordinates(nodeNumber=nowhere))
    mbs.AddObject(
        items.CoordinateVectorConstraint(
            markerNumbers=[void, whole], scalingMarker0=np.zeros((2, 3)), velocityLevel=True,
            constraintUserFunction=lambda _m, _t, _i, q, v, _l: slip(q, v, r),
            jacobianUserFunction=lambda _m, _t, _i, q, _v, _l: rolling_jacobian(q, r),
        )
    )  # fmt: skip


def system_of(job: Job) -> tuple[Any, Any, int]:
    """The container, the assembled system in it, and the sensor of the tree's coordinates."""
    import exudyn as exu
    import exudyn.itemInterface

    items, s = exudyn.itemInterface, job.settings
    container = exu.SystemContainer()
    mbs = container.AddSystem()
    penalty = s.get("contact") == "penalty"
    sunk = job.mass * job.gravity / s["stiffness"] if penalty else 0.0
    node, tree = tree_of(job, mbs, sunk)
    nowhere = mbs.AddNode(items.NodePointGround())
    fixed = mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=nowhere, coordinate=0))
    add_legs(job, mbs, node, fixed)
    if penalty:
        add_contact(job, mbs, tree, sunk)
    else:
        add_rolling(job, mbs, node, nowhere, fixed)
    sensor = mbs.AddSensor(
        items.SensorNode(
            nodeNumber=node,
            storeInternal=True,
            outputVariableType=exu.OutputVariableType.Coordinates,
        )
    )
    mbs.Assemble()
    return container, mbs, sensor


def simulate(job: Job) -> dict[str, Any]:
    """The gait's speed, yaw rate, times, and how far legs and height strayed."""
    import exudyn as exu

    _container, mbs, sensor = system_of(job)
    settings = exu.SimulationSettings()
    settings.timeIntegration.numberOfSteps = job.steps * job.cycles
    settings.timeIntegration.endTime = job.cycles * job.period
    settings.timeIntegration.verboseMode = 0
    settings.solutionSettings.writeSolutionToFile = False
    settings.solutionSettings.sensorsWritePeriod = job.period / job.settings["samples"]
    solver = exu.DynamicSolverType.TrapezoidalIndex2
    _, times = timed(lambda: mbs.SolveDynamic(settings, solverType=solver, showHints=False))
    record = np.array(mbs.GetSensorStoredData(sensor))
    t, states = record[:, 0], record[:, 1:]
    return {
        **motion(states[:, (0, 1, 3)], job), **times,
        "leg_error": float(np.abs(states[-1, 6:] - job.legs(t[-1])[0]).max()),
        "height": [float(f(states[:, 2])) for f in (np.min, np.max)],
    }  # fmt: skip


if __name__ == "__main__":
    answer(simulate, "exudyn")
