"""Claims of the paper about yaw drift: how fast each model turns, and what makes it turn."""

from __future__ import annotations

import math

import numpy as np
import pinocchio as pin

from rrrobot.drive.gaits import Gait, gait
from rrrobot.models.full import FullModel
from rrrobot.models.pivoting import PivotingModel
from rrrobot.paper.item import Item, Result, about, above, below, feature, record
from rrrobot.paper.settled import last_cycle, settled
from rrrobot.paper.workshop import Workshop
from rrrobot.paper.yaw_balance import Attitude, attitude, yaw_balance
from rrrobot.simulation.trajectory import Trajectory

DRIFTS = 5e-4
"""Yaw rate above which a drift of the plane is compared [rad/s]."""
DAMPING = 0.01
"""Of the full model's yaw, eq (9) [N m s/rad]."""


def _drift_larger(shop: Workshop) -> Result:
    full, alone = shop.plane("full").yaw_rate, shop.plane("yaw").yaw_rate
    compared = np.maximum(np.abs(full), np.abs(alone)) > DRIFTS
    larger = float((np.abs(full) > np.abs(alone)).where(compared).mean())
    against = float((full * alone < 0).where(compared).mean())
    at = [
        float(abs(p).sel(offset=math.pi / 4, phase_difference=math.pi / 2, method="nearest"))
        for p in (full, alone)
    ]
    best = [math.degrees(float(np.abs(p).max("phase_difference").idxmax())) for p in (full, alone)]
    folded = [min(b, 180 - b) for b in best]
    rows = (
        feature("circular gait, full model's drift over the yaw model's", "larger", at[0] / at[1],
                limit=above(1.0)),
        feature("gaits of the plane with a larger drift in the full model, share", "larger",
                larger, limit=above(0.9)),
        record("gaits of the plane where the two drift against each other, share", against),
        feature("offset of most drift, full model, from the yaw model's",
                "another than the yaw model's", abs(folded[0] - folded[1]), "deg", limit=above(5)),
        record("offset of most drift, full model", folded[0], "deg"),
        record("offset of most drift, yaw model", folded[1], "deg"),
    )  # fmt: skip
    return Result(rows=rows)


def _drift_cause(shop: Workshop) -> Result:
    robot, circular = shop.robot, gait("circular")
    motion = settled(FullModel(robot), circular)
    drift, given = motion.steady_state().yaw_rate, attitude(motion)
    level, tilted, pitched, all_of_it = (
        _pivoted_drift(shop, circular, a)
        for a in (given.level(), given.tilted(), given.without_roll(), given)
    )
    held = yaw_balance(robot, circular, given, rolls=False).settled_rate(DAMPING).mean()
    ground = yaw_balance(robot, circular, given, rolls=True)
    rate = ground.settled_rate(DAMPING)
    forwards, sideways = ground.mean_moment(rate) / DAMPING
    no_roll = yaw_balance(robot, circular, given.without_roll(), rolls=True)
    twice = settled(FullModel(robot, damping=(0.01, 0.01, 2 * DAMPING)), circular)
    half = settled(FullModel(robot, damping=(0.01, 0.01, DAMPING / 2)), circular)
    inertia, even = (
        yaw_balance(robot, circular, a, rolls=True).inertia for a in (given, given.level())
    )
    pivot = yaw_balance(robot, circular, given, rolls=False).inertia
    products = [k * m.steady_state().yaw_rate / (DAMPING * drift)
                for k, m in ((2 * DAMPING, twice), (DAMPING / 2, half))]  # fmt: skip
    rows = (
        feature("yaw inertia as the body pitches over a level body's, range in the cycle",
                "depends on the pitch", float(np.ptp(inertia / even)), limit=above(0.05)),
        feature("that of the pitching body on the ground over that on a pivot, range",
                "by the rolling contact", float(np.ptp(inertia / pivot)), limit=above(0.05),
                note="The contact lies below the centre: rolling does not change it."),
        record("level body on a pivot: the yaw model's drift", level, "rad/s"),
        record("with the mean pitch held", tilted, "rad/s",
               "The tilt raises the yaw inertia and lowers the drift."),
        feature("with the pitch as it swings: what the paper's reason gives", "larger", pitched,
                "rad/s", limit=above(level),
                note="The inertia's dependence on pitch alone turns the drift round."),
        record("with the roll too", all_of_it, "rad/s"),
        record("the same with the full model's yaw damping", float(held), "rad/s",
               "Damping leaves a pivoted body no drift, whatever its inertia does."),
        record("the same on the ground, over the full model's drift", float(rate.mean()) / drift,
               note="Nothing is missing."),
        record("on the ground without roll", float(no_roll.settled_rate(DAMPING).mean()), "rad/s"),
        record("mean moment of friction about the centre of mass over damping x drift",
               _friction_moment(motion) / (DAMPING * drift)),
        record("share of that moment from rolling sideways", float(sideways / drift),
               note=f"Rolling forwards: {forwards / drift:.2f}."),
        record("full model with half the yaw damping, damping x drift over the paper's",
               products[1]),
        record("full model with twice the yaw damping, damping x drift over the paper's",
               products[0]),
        record("full model with twice the yaw damping, drift over the yaw model's",
               twice.steady_state().yaw_rate / level),
    )  # fmt: skip
    remarks = (
        "The yaw inertia does depend on the pitch, but that is not why the full model drifts "
        "faster. By itself it would make the circular gait drift backwards. Any yaw damping "
        "undoes the drift of a body on a pivot; on the ground it is balanced by the friction "
        "force, whose mean moment about the centre of mass is the damping times the drift, "
        "exactly. On the circular gait all of that moment comes from the sideways velocity of "
        "rolling, that is, from the roll that the paper neglects, times the legs' momentum "
        "forwards.",
        "So the full model's drift goes nearly as one over the yaw damping, while the yaw model "
        "has none; that theirs are of one size is owed to the damping of 0.01 N m s/rad. Above "
        "about 0.015 the yaw model drifts faster.",
    )
    return Result(rows=rows, remarks=remarks)


def _pivoting_turns(shop: Workshop) -> Result:
    robot, circular = shop.robot, gait("circular")
    pivoting = settled(PivotingModel(robot), circular)
    turning, given = pivoting.steady_state().yaw_rate, attitude(pivoting)
    full = settled(FullModel(robot), circular).steady_state().yaw_rate
    level = _pivoted_drift(shop, circular, given.level())
    pitched = _pivoted_drift(shop, circular, given.without_roll())
    coupled = _pivoted_drift(shop, circular, given)
    still = settled(PivotingModel(robot, damping=DAMPING), circular).steady_state().yaw_rate
    light = FullModel(robot, damping=(0.01, 0.01, DAMPING / 10))
    spun = settled(light, circular, cycles=76).steady_state().yaw_rate
    rows = (
        feature("circular gait, pivoting over full model's yaw rate", "significantly faster, 10",
                turning / full, limit=above(5)),
        feature("pivoting model with the full model's yaw damping, yaw rate",
                "nullified", abs(still), "rad/s", limit=below(0.001 * turning)),
        feature("pivoting model's roll and pitch, zero momentum: drift over its yaw rate",
                "coupling of rotations", coupled / turning,
                limit=about(1, 0.0001)),
        feature("its pitch alone, zero momentum: drift over the level body's",
                "coupling of pitch and yaw", pitched / level, limit=above(5),
                note="Only roll and pitch together turn the body fast."),
        record("both models with that yaw damping, pivoting over full", abs(still) / full),
        record("full model with a tenth of the yaw damping, over the pivoting model",
               spun / turning),
    )  # fmt: skip
    remarks = (
        "That yaw damping nullifies the pivoting model's net yaw holds. The coupling explains why "
        "it turns faster than the yaw model, though it takes roll, not pitch and yaw alone. It "
        "does not explain the ratio to the full model, which is coupled too: the paper damps the "
        "yaw of one and not of the other.",
    )
    return Result(rows=rows, remarks=remarks)


def _pivoted_drift(shop: Workshop, legs: Gait, given: Attitude) -> float:
    return float(yaw_balance(shop.robot, legs, given, rolls=False).free_rate().mean())


def _friction_moment(motion: Trajectory) -> float:
    """Mean vertical moment of the ground's force about the centre of mass, last cycle [N m]."""
    cycle, model = last_cycle(motion), motion.robot.model
    data = model.createData()
    centre = np.array([pin.centerOfMass(model, data, q) for q in motion.configuration[cycle]])
    arm, force = motion.position[cycle] - centre[:, :2], motion.contact_force[cycle]
    return float(np.mean(arm[:, 0] * force[:, 1] - arm[:, 1] * force[:, 0]))


DRIFT_CLAIMS = (
    Item(
        key="claim-yaw-drift",
        title="The full model's yaw drifts faster than the yaw model's",
        shows="The yaw drift rate is larger in the full model, and the leg cycles of most yaw are "
        "different ones (sec. 4.2.2).",
        make=_drift_larger,
    ),
    Item(
        key="claim-yaw-drift-cause",
        title="The reason is a yaw inertia that depends on the pitch",
        shows="The yaw inertia of the full model depends on the body's pitch, because of the "
        "rolling contact; this causes the larger yaw drift (sec. 4.2.2).",
        make=_drift_cause,
    ),
    Item(
        key="claim-pivoting-turns",
        title="The pivoting model turns faster because its rotations are coupled",
        shows="The pivoting model turns about ten times as fast, because of the coupling and "
        "transfer of energy between pitch and yaw; yaw damping would nullify its net yaw "
        "(sec. 4.1).",
        make=_pivoting_turns,
    ),
)
