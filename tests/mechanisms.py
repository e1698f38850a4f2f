"""Robots whose joints mimic, of random geometry, and the same ones written by hand without."""

import numpy as np

import rrrobot as rr

RATIOS = {"b_knee": (-1.5, 0.3), "c_foot": (0.5, -0.2), "slide": (0.04, 0.01)}
"""mimic joint -> multiplier and offset, all of hip"""


def link(name, mass, rng):
    x, y, z = rng.uniform(-0.05, 0.05, 3)
    a, b, c = np.sort(rng.uniform(1e-3, 2e-3, 3))
    return (
        f'<link name="{name}"><inertial><origin xyz="{x} {y} {z}" rpy="0.3 -0.2 0.1"/>'
        f'<mass value="{mass}"/><inertia ixx="{a}" ixy="0" ixz="0" iyy="{b}" iyz="0" izz="{c}"/>'
        "</inertial></link>"
    )


def joint(name, parent, kind, rng, extra=""):
    xyz, rpy, axis = rng.uniform(-0.1, 0.1, 3), rng.uniform(-1, 1, 3), rng.normal(size=3)
    words = [" ".join(map(repr, v.tolist())) for v in (xyz, rpy, axis / np.linalg.norm(axis))]
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{name}_link"/>'
        f'<origin xyz="{words[0]}" rpy="{words[1]}"/><axis xyz="{words[2]}"/>'
        f'<limit effort="9" velocity="99" lower="-9" upper="9"/>{extra}</joint>'
    )


def mimic_urdf(*, mimics, seed=0):
    """A body, a hip, a free tail, and joints that follow the hip: before it in the alphabet, below
    it, through another one, and a slide."""
    rng = np.random.default_rng(seed)

    def follows(master, ratio, offset):
        if not mimics:
            return ""
        return f'<mimic joint="{master}" multiplier="{ratio}" offset="{offset}"/>'

    # The foot's own rule is of the knee: 0.5 hip - 0.2 = -(1/3)(-1.5 hip + 0.3) - 0.1.
    parts = [
        link("body", 2.0, rng),
        link("hip_link", 0.3, rng), joint("hip", "body", "continuous", rng),
        link("b_knee_link", 0.2, rng),
        joint("b_knee", "body", "continuous", rng, follows("hip", -1.5, 0.3)),
        link("c_foot_link", 0.1, rng),
        joint("c_foot", "hip_link", "revolute", rng, follows("b_knee", -1 / 3, -0.1)),
        link("slide_link", 0.1, rng),
        joint("slide", "b_knee_link", "prismatic", rng, follows("hip", 0.04, 0.01)),
        link("tail_link", 0.2, rng), joint("tail", "c_foot_link", "revolute", rng),
    ]  # fmt: skip
    return f'<robot name="mimics">{"".join(parts)}</robot>'


LEGS = ("hip", "tail")
EVERY = ("hip", "tail", *RATIOS)


def pair(seed=0, shell=None):
    """The robot with mimic joints, and the same with five legs of its own."""
    shell = shell or rr.Sphere(0.3)
    follows = rr.Robot.from_urdf(mimic_urdf(mimics=True, seed=seed), shell=shell, legs=LEGS)
    free = rr.Robot.from_urdf(mimic_urdf(mimics=False, seed=seed), shell=shell, legs=EVERY)
    return follows, free


def spread(values, *, offset):
    """Coordinates or rates (..., 5) of all five joints of those of hip and tail (..., 2)."""
    values = np.asarray(values)
    hip = values[..., 0]
    columns = [hip, values[..., 1], *(m * hip + (b if offset else 0) for m, b in RATIOS.values())]
    return np.stack(columns, axis=-1)


MATRIX = spread(np.eye(2), offset=False).T
"""(5, 2): rates of all joints of those of hip and tail."""
