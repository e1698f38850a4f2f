"""The snakeboard of Ostrowski, Lewis, Murray and Burdick: mixed, three motors, two axles."""

from __future__ import annotations

import numpy as np

from rrrobot.drive.gaits import SinusoidalGait
from rrrobot.errors import ParameterError
from rrrobot.machines.looks import ORANGE, axle, box, rod
from rrrobot.machines.machine import Machine
from rrrobot.machines.mechanism import Mechanism
from rrrobot.machines.tree import Joint, Link, Tree, flat
from rrrobot.rows import NoSideSlip


def snakeboard(
    *,
    m: float = 6.0,
    J: float = 0.016,
    Jr: float = 0.072,
    Jw: float = 0.0013,
    l: float = 0.2,  # noqa: E741
    m_rotor: float = 0.0,
    m_truck: float = 0.0,
) -> Machine:
    """A board with a rotor at its centre and a steered axle at each end.

    Shape (psi, phi_front, phi_back); T = m |v|^2 / 2 + J theta_dot^2 / 2 + Jr (theta_dot +
    psi_dot)^2 / 2 + Jw ((theta_dot + phi_f_dot)^2 + (theta_dot + phi_b_dot)^2) / 2. Singular where
    both axles lie along the board. Gaits "drive", "rotate" and "park" turn the rotor and the axles
    at 1:1, 2:1 and 3:2.

    Args:
        m: total mass [kg].
        J: of the board about its centre, with the trucks as points [kg m^2].
        Jr, Jw: of the rotor, of each truck [kg m^2].
        l: from the centre to each axle [m].
        m_rotor, m_truck: parts of m; where the mass sits changes nothing.

    Example:
        >>> import rrrobot as rr
        >>> rr.machines.snakeboard().model.n_shape
        3
    """
    rest = m - m_rotor - 2 * m_truck
    if rest < 0 or 2 * m_truck * l**2 > J:
        raise ParameterError(
            f"m = {m} kg and J = {J} kg m^2 are those of the whole board: they must be at least "
            f"those of its rotor and trucks, {m_rotor + 2 * m_truck} kg and "
            f"{2 * m_truck * l**2:.4g} kg m^2."
        )
    deck = (box((2.4 * l, 0.5 * l, 0.06 * l), (0, 0, 0.25 * l)),)
    weight = box((1.4 * l, 0.2 * l, 0.15 * l), (0, 0, 0.6 * l), ORANGE)
    bar = (rod("z", 0.04 * l, 0.3 * l, (0, 0, 0.4 * l)), weight)
    truck = axle(0.0, 0.4 * l, 0.15 * l)
    front = Link("front_link", m_truck, flat(Jw), looks=truck)
    back = Link("back_link", m_truck, flat(Jw), looks=truck)
    tree = Tree(
        Link("board", rest, flat(J - 2 * m_truck * l**2), looks=deck),
        [
            Joint("rotor", "board", Link("rotor_link", m_rotor, flat(Jr), looks=bar)),
            Joint("front_truck", "board", front, (l, 0, 0)),
            Joint("back_truck", "board", back, (-l, 0, 0)),
        ],
        root="planar",
        height=0.15 * l,
    )
    model = tree.model()
    edges = [
        NoSideSlip(model, model.getFrameId(f"{end}_link"), name=end) for end in ("front", "back")
    ]
    return Machine(
        name="snakeboard",
        title="snakeboard: a board on two steered axles, driven by a rotor",
        tree=tree,
        model=Mechanism(model, edges, motors=("rotor", "front_truck", "back_truck")),
        gaits={
            name: SinusoidalGait(
                offset=0.0,
                amplitude=(0.7, 0.3, 0.3),
                angular_frequency=(rotor, axles, axles),
                phase=(0.0, 0.0, np.pi),
            )
            for name, rotor, axles in (("drive", 1, 1), ("rotate", 2, 1), ("park", 3, 2))
        },
        shape=(0.0, 0.1, -0.1),
    )
