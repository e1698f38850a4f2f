"""RRRobots in two forms, five points and the library's robot, and random states of them."""

import functools
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

import rrrobot as rr
from tests.derivations import PointMassRobot

Array = NDArray[np.float64]

TABLE_2 = PointMassRobot()
UNEQUAL = PointMassRobot(
    battery_mass=0.27,
    servo_masses=(0.06, 0.041),
    leg_masses=(0.05, 0.083),
    leg_lengths=(0.09, 0.115),
    shell_radius=0.13,
    hip_offset=0.1,
    gravity=9.7,
)


def parameters(points: PointMassRobot) -> rr.RRRobotParameters:
    return rr.RRRobotParameters(
        battery_mass=points.battery_mass,
        servo_mass=points.servo_masses,
        leg_mass=points.leg_masses,
        leg_length=points.leg_lengths,
        shell_radius=points.shell_radius,
        hip_offset=points.hip_offset,
        gravity=points.gravity,
    )


@functools.cache
def library_robot(points: PointMassRobot = TABLE_2) -> rr.Robot:
    return rr.Robot.from_parameters(parameters(points))


def random_points(rng: np.random.Generator) -> PointMassRobot:
    """Five points with unequal legs and b != r, the masses and lengths within a factor of four."""

    def pair(low: float, high: float) -> tuple[float, float]:
        first, second = rng.uniform(low, high, 2)
        return float(first), float(second)

    return PointMassRobot(
        battery_mass=rng.uniform(0.2, 0.5),
        servo_masses=pair(0.03, 0.1),
        leg_masses=pair(0.03, 0.1),
        leg_lengths=pair(0.05, 0.1),
        shell_radius=rng.uniform(0.105, 0.2),
        hip_offset=rng.uniform(0.05, 0.25),
        gravity=rng.uniform(1.6, 20.0),
    )


class State(NamedTuple):
    """A random state; angles are kept away from pitch = pi/2."""

    theta: Array
    """roll, pitch, yaw [rad]"""
    theta_dot: Array
    """[rad/s]"""
    leg: rr.drive.LegMotion
    """angles anywhere, rates and accelerations of a few rad/s, rad/s^2"""
    torque: Array
    """[N m]"""
    coefficients: Array
    """five damping coefficients: three of the body, one of the legs, one spare [N m s/rad]"""


def random_state(rng: np.random.Generator) -> State:
    turn = rng.uniform(-1, 1, 3) * (np.pi, 1.2, np.pi)
    leg = rr.drive.LegMotion(rng.uniform(-np.pi, np.pi, 2), *rng.uniform(-5, 5, (2, 2)))
    return State(turn, rng.uniform(-4, 4, 3), leg, *_scaled(rng, 0.1, 2), *_scaled(rng, 0.02, 5))


def _scaled(rng: np.random.Generator, scale: float, size: int) -> list[Array]:
    return [scale * rng.uniform(0.1, 1.0, size)]


@functools.cache
def tree_robot(seed: int, centred: bool = False) -> rr.Robot:
    """A spherical shell, ballast at its bottom, and a random tree of four joints of every kind.

    The shell is off the root's origin unless `centred`.
    """
    rng = np.random.default_rng(seed)

    def inertial(mass: float, at: Array) -> str:
        a = rng.uniform(-0.05, 0.05, (3, 3))
        second = mass * (a @ a.T + 1e-3 * np.eye(3))
        body = np.trace(second) * np.eye(3) - second  # as a body can have it
        pairs = ("xx", "yy", "zz", "xy", "xz", "yz")
        entries = " ".join(
            f'i{ij}="{body["xyz".index(ij[0]), "xyz".index(ij[1])]}"' for ij in pairs
        )
        xyz = " ".join(map(str, at))
        return (
            f'<inertial><origin xyz="{xyz}"/><mass value="{mass}"/><inertia {entries}/></inertial>'
        )

    centre = rng.uniform(-0.03, 0.03, 3) * (not centred)
    ballast = centre + np.append(rng.uniform(-0.02, 0.02, 2), -0.12)
    links = [f'<link name="root">{inertial(2.0, ballast)}</link>']
    joints = []
    kinds = ("revolute", "continuous", "prismatic", "revolute")
    for i, kind in enumerate(kinds):
        parent = "root" if i == 0 else f"link{rng.integers(i)}"
        axis, xyz, rpy = rng.normal(size=3), rng.uniform(-0.06, 0.06, 3), rng.uniform(-1, 1, 3)
        links.append(
            f'<link name="link{i}">'
            f"{inertial(rng.uniform(0.1, 0.4), rng.uniform(-0.05, 0.05, 3))}</link>"
        )
        joints.append(
            f'<joint name="joint{i}" type="{kind}"><parent link="{parent}"/>'
            f'<child link="link{i}"/><origin xyz="{" ".join(map(str, xyz))}" '
            f'rpy="{" ".join(map(str, rpy))}"/>'
            f'<axis xyz="{" ".join(map(str, axis / np.linalg.norm(axis)))}"/>'
            '<limit lower="-9" upper="9" effort="9" velocity="9"/></joint>'
        )
    urdf = f'<robot name="tree">{"".join(links)}{"".join(joints)}</robot>'
    return rr.Robot.from_urdf(urdf, shell=rr.Sphere(0.2), shell_center=centre)


def tree_ground(seed: int) -> rr.Plane:
    """Level for even seeds, a slope for odd ones."""
    return rr.Plane((0.05, -0.1, 1.0) if seed % 2 else (0.0, 0.0, 1.0))


def error(value: ArrayLike, expected: ArrayLike) -> float:
    """Largest difference over the largest expected entry; both must have the same shape."""
    found, wanted = np.asarray(value, dtype=float), np.asarray(expected, dtype=float)
    assert found.shape == wanted.shape
    return float(np.abs(found - wanted).max() / np.abs(wanted).max())


def coriolis_checks(model: Any, q: Array, v: Array) -> tuple[float, float]:
    """How far M_dot - 2 C is from skew-symmetric, and C v from Pinocchio's bias without gravity.

    M_dot is the fourth-order central difference along q_dot = v; both results are relative.
    """
    import pinocchio as pin

    data = model.createData()

    def mass(t: float) -> Array:
        return np.array(pin.crba(model, data, pin.integrate(model, q, t * v)))

    h = 1e-3
    mass_rate = (8 * (mass(h) - mass(-h)) - (mass(2 * h) - mass(-2 * h))) / (12 * h)
    C = np.array(pin.computeCoriolisMatrix(model, data, q, v))
    gravity = np.array(pin.computeGeneralizedGravity(model, data, q))
    bias = np.array(pin.nonLinearEffects(model, data, q, v))
    skew = mass_rate - 2 * C
    scale = np.abs(C).max()
    return (
        float(np.abs(skew + skew.T).max() / scale),
        float(np.abs(C @ v - (bias - gravity)).max() / np.abs(C @ v).max()),
    )
