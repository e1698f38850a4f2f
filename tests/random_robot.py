"""Random robots for tests: a tree of one-degree-of-freedom joints with full inertias."""

from __future__ import annotations

import numpy as np

import rrrobot as rr


def random_urdf(seed: int, joints: int = 12) -> str:
    """URDF text of a random tree: revolute, prismatic and continuous joints, any axis."""
    rng = np.random.default_rng(seed)
    parts = ['<robot name="random">', _link("base", rng, mass=3.0, low=True)]
    for i in range(joints):
        kind = ("revolute", "prismatic", "continuous")[i % 3]
        # Parents that are not the link before make branches.
        parent = "base" if i < 3 else f"link_{rng.integers(0, i)}"
        axis = rng.normal(size=3)
        axis /= np.linalg.norm(axis)
        parts.append(_link(f"link_{i}", rng, mass=0.05))
        parts.append(
            f'<joint name="joint_{i:02d}" type="{kind}">'
            f'<parent link="{parent}"/><child link="link_{i}"/>'
            f'<origin xyz="{_text(0.05 * rng.normal(size=3))}" rpy="{_text(rng.normal(size=3))}"/>'
            f'<axis xyz="{_text(axis)}"/>'
            '<limit lower="-10" upper="10" effort="100" velocity="100"/></joint>'
        )
    return "".join([*parts, "</robot>"])


def random_robot(seed: int, joints: int = 12, **options: object) -> rr.Robot:
    """Robot of `random_urdf`, by default with a spherical shell off the base's origin."""
    settings = {"shell": rr.Sphere(0.3), "shell_center": (0.02, -0.01, 0.03)} | options
    return rr.Robot.from_urdf(random_urdf(seed, joints), **settings)  # type: ignore[arg-type]


def random_state(
    robot: rr.Robot, seed: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """(pose, omega_body, leg angles, leg rates) of a robot in the full model."""
    rng = np.random.default_rng(seed)
    model = rr.FullModel(robot)
    pose = model.make_pose(rng.uniform(-1, 1, 3), rng.normal(size=2))
    n = robot.n_legs
    return pose, rng.normal(size=3), rng.uniform(-1.5, 1.5, n), rng.normal(size=n)


def _link(name: str, rng: np.random.Generator, mass: float, low: bool = False) -> str:
    size = 0.02 + 0.05 * rng.random(3)
    orientation = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    principal = mass * np.array([size[1] ** 2 + size[2] ** 2, size[0] ** 2 + size[2] ** 2,
                                 size[0] ** 2 + size[1] ** 2])  # fmt: skip
    inertia = orientation @ np.diag(principal) @ orientation.T
    center = 0.03 * rng.normal(size=3) + ((0, 0, -0.2) if low else (0, 0, 0))
    entries = {"ixx": (0, 0), "ixy": (0, 1), "ixz": (0, 2), "iyy": (1, 1), "iyz": (1, 2),
               "izz": (2, 2)}  # fmt: skip
    values = " ".join(f'{k}="{inertia[i, j]!r}"' for k, (i, j) in entries.items())
    return (
        (
            f'<link name="{name}"><inertial><origin xyz="{_text(center)}"/>'
            f'<mass value="{mass * (0.5 + rng.random())!r}"/><inertia {values}/></inertial></link>'
        )
        .replace("np.float64(", "")
        .replace(")", "")
    )


def _text(values: np.ndarray) -> str:
    return " ".join(repr(float(v)) for v in values)
