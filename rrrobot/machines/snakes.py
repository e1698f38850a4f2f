"""The three-link kinematic snake of Shammas, Choset and Rizzi: its shape alone moves it."""

from __future__ import annotations

from math import pi

from rrrobot.drive.gaits import SinusoidalGait
from rrrobot.machines.looks import BLUE, SAND, axle, box
from rrrobot.machines.machine import Machine
from rrrobot.machines.mechanism import Mechanism
from rrrobot.machines.tree import Joint, Link, Tree, flat
from rrrobot.rows import NoSideSlip


def kinematic_snake(*, L: float = 0.15, m: float = 0.5, I: float = 0.00375) -> Machine:  # noqa: E741
    """Three links with an axle in the middle of each; the base is the middle link.

    Shape (a1, a2): the rear joint at (-L, 0) and the front joint at (L, 0). Three rows for three
    freedoms: the connection is kinematic, masses only set the torques. Singular on a1 = -a2, where
    the axles meet in one point, and where a link is folded back.

    Args:
        L: half a link's length [m].
        m, I: each link's mass [kg] and inertia about its centre [kg m^2].

    Example:
        >>> import rrrobot as rr
        >>> snake = rr.machines.kinematic_snake()
        >>> snake.simulate(snake.gaits["circle"], 6.283185307179586).pose[-1, :2].round(4).tolist()
        [-0.0806, -0.0606]
    """
    looks = [
        (box((1.8 * L, 0.25 * L, 0.2 * L), (x, 0, 0.2 * L), colour), *axle(x, 0.35 * L, 0.2 * L))
        for x, colour in ((-L, BLUE), (0.0, SAND), (L, BLUE))
    ]
    rear = Link("rear_link", m, flat(I), (-L, 0, 0), looks[0])
    front = Link("front_link", m, flat(I), (L, 0, 0), looks[2])
    tree = Tree(
        Link("middle_link", m, flat(I), looks=looks[1]),
        [
            Joint("rear", "middle_link", rear, (-L, 0, 0)),
            Joint("front", "middle_link", front, (L, 0, 0)),
        ],
        root="planar",
        height=0.2 * L,
        frames=[
            ("rear_axle", "rear_link", (-L, 0, 0)),
            ("middle_axle", "middle_link", (0.0, 0, 0)),
            ("front_axle", "front_link", (L, 0, 0)),
        ],
    )
    model = tree.model()
    axles = [
        NoSideSlip(model, model.getFrameId(f"{end}_axle"), name=end)
        for end in ("rear", "middle", "front")
    ]
    return Machine(
        name="kinematic_snake",
        title="kinematic snake: three links on an axle each",
        tree=tree,
        model=Mechanism(model, axles, motors=("rear", "front")),
        gaits={
            "circle": SinusoidalGait(
                offset=1.0, amplitude=0.5, angular_frequency=1.0, phase=(pi / 2, 0.0)
            ),
            "turn": SinusoidalGait(
                offset=(1.2, 0.8), amplitude=(0.3, 0.5), angular_frequency=1.0, phase=(pi / 2, 0.3)
            ),
        },
        shape=(1.0, 0.5),
    )
