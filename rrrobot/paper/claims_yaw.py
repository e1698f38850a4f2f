"""Claims of the paper about yaw: its conservation law, its reduction, its amplitude."""

from __future__ import annotations

import math

import numpy as np

from rrrobot.checks import Array
from rrrobot.contact.ground import Plane
from rrrobot.drive.gaits import FourierGait, gait
from rrrobot.drive.moves import LegMoves, Loops, one_leg_gait, out_of_phase_gait
from rrrobot.models.full import FullModel
from rrrobot.models.pivoting import PivotingModel
from rrrobot.models.single_axis import PitchModel, RollModel, YawModel
from rrrobot.paper.item import Item, Result, Row, above, below, feature, record
from rrrobot.paper.settled import both_legs, settled
from rrrobot.paper.workshop import FREQUENCY, HUMP, Workshop, hump, relative_rms
from rrrobot.paper.yaw_balance import attitude, yaw_balance
from rrrobot.reduction.checks import path_controllability, reducibility
from rrrobot.reduction.yaw import net_yaw
from rrrobot.simulation.run import simulate
from rrrobot.steering.yaw_planner import plan_yaw


def _momentum_conserved(shop: Workshop) -> Result:
    model = YawModel(shop.robot)
    circular, span = gait("circular"), 20 * 2 * math.pi / FREQUENCY
    spun = simulate(model, circular, span, span / 640, start="rest")
    momenta = [
        float(model.momentum(*model.split(y)[:2], angle, rate)[0])
        for y, angle, rate in zip(spun.state, spun.leg_angle, spun.leg_rate, strict=True)
    ]
    plan = one_leg_gait((1.2, 1.5), leg=0, target=2.0)
    moved = simulate(model, plan, plan.duration, plan.duration / 100, start="rest")
    rows = (
        feature(
            "change of the momentum over 20 cycles, over itself", "conserved",
            float(np.ptp(momenta) / abs(momenta[0])),
            limit=below(1e-08),
            note="From a body at rest over legs that swing, so that there is momentum.",
        ),
        feature(
            "yaw rate when the legs stop after a move from rest", "stationary",
            abs(float(moved.euler_rates[-1, 2])), "rad/s",
            limit=below(1e-06),
        ),
        record("largest yaw rate on the way", np.abs(moved.euler_rates[:, 2]).max(), "rad/s"),
    )  # fmt: skip
    return Result(rows=rows)


def _cycles_of_legs(shop: Workshop) -> Result:
    robot, up = shop.robot, math.pi / 2
    about = [
        abs(net_yaw(robot, both_legs(up, lead, amplitude=(0.3, swing))))
        for lead in (0.5, up, 2.5)
        for swing in (0.3, 0.6)
    ]
    offset = out_of_phase_gait(offset=5 * math.pi / 8 + 0.15)
    turned = net_yaw(robot, offset)
    in_phase = max(abs(net_yaw(robot, both_legs(1.0, lead))) for lead in (0.0, math.pi))
    loop = Loops(
        center=offset.offset, amplitude=offset.amplitude, phase=offset.phase, turns=1, duration=3.0
    )
    eased = net_yaw(robot, LegMoves([loop]), method="simulate")
    lopsided = FourierGait(
        offset=(up, up), sine=[[0.5, 0.0], [0.0, 0.3]], cosine=[[0.0, 0.5], [0.3, 0.0]],
        angular_frequency=FREQUENCY,
    )  # fmt: skip
    mirrored = net_yaw(robot, both_legs((up + 0.4, up - 0.4)))
    one = net_yaw(robot, one_leg_gait((1.2, 1.5), leg=0, target=2.0))
    rows = (
        feature("cycles about the vertical, six sinusoids, most net yaw", "zero", max(about), "rad",
                limit=below(1e-12)),
        feature("cycle about 5 pi/8 + 0.15, size of the net yaw", "not zero", abs(turned), "rad",
                limit=above(1e-3)),
        feature("legs in phase or opposite about 1 rad, most net yaw", "needs the right phase",
                in_phase, "rad", limit=below(1e-12)),
        feature("one leg moves from 1.2 to 2 rad, size of the net yaw", "not zero", abs(one), "rad",
                limit=above(1e-3)),
        feature("the same cycle from rest to rest in 3 s, by the dynamics, off the above",
                "independent of time", abs(eased - turned), "rad",
                limit=below(1e-08)),
        record("cycle about (90 + 23, 90 - 23) deg, net yaw", mirrored, "rad",
               "Offsets of opposite sign cancel: it is the common offset that turns."),
        record("lopsided cycle about the vertical (second harmonics), net yaw",
               net_yaw(robot, lopsided), "rad", "Without that symmetry it need not be 0."),
    )  # fmt: skip
    return Result(rows=rows)


def _reductions(shop: Workshop) -> Result:
    rows: list[Row] = []
    for kind in (YawModel, PitchModel, RollModel, PivotingModel, FullModel):
        model = kind(shop.robot)
        found = reducibility(model)
        words = "has one" if model.name == "yaw" else "has none"
        rows.append(
            feature(
                f"{model.name} model, body's acceleration outside the law", words,
                max(found.gravity, found.damping, found.inertia), "rad/s^2",
                limit=below(1e-9) if model.name == "yaw" else above(1e-3),
            )
        )  # fmt: skip
    afloat = reducibility(PivotingModel(shop.robot, ground=Plane(gravity=0.0), damping=None))
    note = "It reduces: gravity and damping are all that stands in the way."
    name = "pivoting model without gravity and damping, the same"
    rows.append(record(name, afloat.inertia, "rad/s^2", note if afloat.reducible else ""))
    postures = np.stack(np.meshgrid(*2 * [np.linspace(0.3, 2.8, 6)]), axis=-1).reshape(-1, 2)
    ranks = [c.rank for c in path_controllability(shop.robot, postures)]
    goal = (0.3, 1.8, 1.0)
    plan = plan_yaw(shop.robot, (0.0, 1.2, 1.6), goal, angle_range=(0.4, 2.7))
    end = simulate(YawModel(shop.robot), plan.gait, plan.duration, plan.duration, start="rest")
    miss = np.abs((end.euler[-1, 2], *end.leg_angle[-1]) - np.array(goal)).max()
    rows += [
        feature("yaw model, postures of 36 with all directions in reach", "controllable",
                ranks.count(3), limit=above(len(ranks) - 1)),
        feature("yaw model, off its goal after both gaits by a plan", "reaches any configuration",
                float(miss), "rad", limit=below(1e-05)),
    ]  # fmt: skip
    return Result(rows=tuple(rows))


def _yaw_amplitude(shop: Workshop) -> Result:
    full, alone = shop.plane("full").yaw_amplitude, shop.plane("yaw").yaw_amplitude
    peak, flat, off = hump(alone), hump(full), relative_rms(full, alone)
    circular = gait("circular")
    motion = settled(FullModel(shop.robot), circular)
    given = attitude(motion)
    level, tilted = (
        yaw_balance(shop.robot, circular, a, rolls=False) for a in (given.level(), given.tilted())
    )
    heavier = float(tilted.inertia.mean() / level.inertia.mean())
    slower = _first_harmonic(tilted.free_rate()) / _first_harmonic(level.free_rate())
    rolling = yaw_balance(shop.robot, circular, given, rolls=False)
    rolled = _first_harmonic(rolling.free_rate()) / _first_harmonic(level.free_rate())
    whole = float(motion.steady_state().amplitude[2]) / _first_harmonic(level.free_rate())
    rows = (
        feature("yaw model, amplitude at offset 90 over 45 deg, legs opposite", "a hump", peak,
                limit=above(HUMP)),
        feature("full model, the same", "no spike", flat, limit=below(HUMP)),
        feature("yaw model less full model, rms over the plane over the full model's",
                "compares favourably", off, limit=below(0.1),
                note="The yaw model's amplitude vanishes at offset 0, the full model's does not."),
        feature("yaw inertia at the circular gait's mean pitch over that of a level body",
                "larger", heavier, limit=above(1.0)),
        feature("yaw model tilted by the mean pitch, amplitude over a level one's", "smaller",
                slower, limit=below(1.0)),
        record("yaw model given the full model's pitch and roll, the same", rolled),
        feature("circular gait, full model's yaw amplitude over the yaw model's", "smaller", whole,
                limit=below(1.0),
                note="The body's roll makes up for what the tilt takes away, and more."),
    )  # fmt: skip
    return Result(rows=rows)


def _first_harmonic(rate: Array) -> float:
    """Amplitude of the angle whose rate over one cycle is given [rad]."""
    return float(2 * np.abs(np.fft.rfft(rate))[1] / rate.size / FREQUENCY)


YAW_CLAIMS = (
    Item(
        key="claim-yaw-momentum",
        title="The yaw model keeps its momentum",
        shows="Yaw momentum is conserved in the yaw model; started at rest, the body is stationary "
        "when the legs are (sec. 4.2.2).",
        make=_momentum_conserved,
    ),
    Item(
        key="claim-leg-cycles",
        title="Leg cycles off the vertical turn the yaw model, others do not",
        shows="Cycles about the vertical give no net yaw, others do with the right phase, and so "
        "does one leg's move; it depends on the legs' path and not on time (sec. 4.2.2).",
        make=_cycles_of_legs,
    ),
    Item(
        key="claim-reduction",
        title="The yaw model alone has a kinematic reduction",
        shows="The yaw model has a kinematic reduction and reaches any configuration; the pitch "
        "and the full model have none, because of gravity (sec. 2.2, sec. 4.2).",
        make=_reductions,
    ),
    Item(
        key="claim-yaw-amplitude",
        title="The full model yaws less, and has no hump at the vertical",
        shows="The yaw model's amplitude compares favourably but has a small hump near offset "
        "pi/2. Off the vertical the full robot pitches, its yaw inertia increases, and it yaws "
        "less (sec. 4.2.2, Fig 12).",
        make=_yaw_amplitude,
    ),
)
