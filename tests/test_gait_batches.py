"""One form of many gaits: every periodic gait is harmonics, and can be swept and optimised."""

from __future__ import annotations

import numpy as np
import pytest

import rrrobot as rr
from rrrobot.drive.gaits import GaitBatch
from rrrobot.momentum.legs import checked
from rrrobot.momentum.lowering import lower
from rrrobot.simulation.heights import clearance
from tests.random_robot import random_robot

# Legs that go round clear the ground.
FULL = rr.FullModel(rr.Robot.from_parameters(rr.RRRobotParameters(leg_length=0.07)))
CYCLES, STEPS = 20, 48


def sampled() -> rr.SampledGait:
    """One leg swings, the other goes round, both unevenly."""
    time = np.linspace(0.0, 1.2, 61)
    u = 2 * np.pi * time / 1.2
    legs = np.column_stack((1.2 + 0.2 * np.sin(u + 0.3 * np.sin(u)), 0.4 - u + 0.1 * np.cos(2 * u)))
    legs[-1] = legs[0] + (0.0, -2 * np.pi)
    return rr.SampledGait(time, legs)


KINDS = {
    "sinusoidal": rr.SinusoidalGait(
        offset=(1.2, 0.9), amplitude=(0.3, 0.2), angular_frequency=7.0, phase=(0.4, 1.9)
    ),
    "one leg": rr.SinusoidalGait(offset=(1.2, 0.9), amplitude=(0.3, 0.0), angular_frequency=7.0),
    "two frequencies": rr.SinusoidalGait(
        offset=(1.2, 0.9), amplitude=0.2, angular_frequency=(4.0, 6.0), phase=(0.3, 0.9)
    ),
    "fourier": rr.FourierGait(
        offset=(1.2, 0.9), cosine=[[0.1, 0.2], [0.05, -0.1]], sine=[[0.1, 0], [0, 0.1]],
        angular_frequency=6.0,
    ),
    "constant rates": rr.FourierGait(
        offset=(0.4, 0.9), cosine=[[0, 0]], sine=[[0, 0]], angular_frequency=5.0, winding=(1, -1)
    ),
    "round and swinging": rr.FourierGait(
        offset=(0.4, 0.9), cosine=[[0.1, 0]], sine=[[0, 0.2]], angular_frequency=5.0,
        winding=(2, 0),
    ),
    "sampled": sampled(),
    "callable": rr.CallableGait(
        lambda t: (
            np.array([1.0 + 0.2 * np.exp(np.sin(6 * t)), 1.5]),
            np.array([1.2 * np.cos(6 * t) * np.exp(np.sin(6 * t)), 0.0]),
            np.array([7.2 * (np.cos(6 * t) ** 2 - np.sin(6 * t)) * np.exp(np.sin(6 * t)), 0.0]),
        ),
        n_legs=2, period=2 * np.pi / 6,
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", KINDS)
def test_harmonics_are_the_gait(name: str) -> None:
    gait = KINDS[name]
    batch = GaitBatch.of([rr.gait("lateral"), gait])
    again = batch.gait(1)
    time = np.linspace(-3.0, 9.0, 400)
    tolerance = 1e-5 if name in ("sampled", "callable") else 1e-12
    for part, (a, b) in enumerate(zip(gait(time), again(time), strict=True)):
        # A harmonic's rate is at most so many times its angle.
        np.testing.assert_allclose(b, a, atol=tolerance * 100**part)
    rate, acceleration = batch.fastest()
    assert rate[1] == pytest.approx(np.abs(gait(time).rate).max(), rel=2e-3)
    assert acceleration[1] == pytest.approx(np.abs(gait(time).acceleration).max(), rel=2e-2,
                                            abs=1e-9)  # fmt: skip


@pytest.mark.slow
def test_a_sweep_of_every_kind_gives_the_steady_states_of_simulations() -> None:
    ds = rr.sweep(FULL, points=list(KINDS.values()), cycles=CYCLES, progress=False, threads=1)
    # The gait with the most harmonics says how many steps all have.
    assert ds.status.values.tolist() == [0] * len(KINDS)
    assert ds.sine.dims == ("gait", "harmonic", "leg") and ds.attrs["steps_per_cycle"] > 16
    for i, (name, gait) in enumerate(KINDS.items()):
        t = rr.simulate(
            FULL, gait, CYCLES * gait.period, gait.period / 200, method="momentum",
            step=gait.period / 400,
        )  # fmt: skip
        state = t.steady_state(after=(CYCLES - int(ds.attrs["counted"])) * gait.period)
        row = ds.isel(gait=i)
        close = 2e-4 if name in ("sampled", "callable") else 1e-5
        assert float(row.speed) == pytest.approx(state.speed, rel=close, abs=1e-9), name
        assert float(row.yaw_rate) == pytest.approx(state.yaw_rate, rel=close, abs=1e-8), name
        np.testing.assert_allclose(row.roll_amplitude, state.amplitude[0], atol=close / 100)
        least = clearance(t, slice(-201, None))
        assert float(row.clearance) == pytest.approx(least, abs=1e-4), name


def test_few_steps_are_enough_for_legs_that_go_round() -> None:
    some = {"amplitude": (0.0, 0.2), "offset": (0.4, 0.9), "angular_frequency": 5.0}
    few = rr.sweep(FULL, winding=([1, -2], 0), **some, cycles=CYCLES, loads=True)
    assert few.attrs["steps_per_cycle"] == 24 and few.winding_leg_1.values.tolist() == [1, -2]
    many = rr.sweep(FULL, winding=([1, -2], 0), **some, cycles=CYCLES, loads=True,
                    steps_per_cycle=96)  # fmt: skip
    for name, close in {"speed": 2e-4, "yaw_rate": 2e-4, "clearance": 1e-2, "peak_torque": 2e-3,
                        "normal_force": 5e-3}.items():  # fmt: skip
        np.testing.assert_allclose(few[name], many[name], rtol=close, err_msg=name)
    gait = rr.FourierGait(offset=(0.4, 0.9), cosine=[[0, 0.2]], sine=[[0, 0]],
                          angular_frequency=5.0, winding=(1, 0))  # fmt: skip
    one = rr.sweep(FULL, points=[gait], cycles=CYCLES, steps_per_cycle=24)
    own = rr.sweep(FULL, winding=([1], 0), **some | {"phase": (0.0, np.pi / 2)}, cycles=CYCLES,
                   steps_per_cycle=24)  # fmt: skip
    assert float(one.speed[0]) == pytest.approx(float(own.speed[0]), rel=1e-12)


def test_limit_cycles_of_legs_that_go_round() -> None:
    one = rr.sweep(FULL, points=[KINDS["constant rates"]], settle="orbit", steps_per_cycle=24)
    orbit = rr.limit_cycle(FULL, KINDS["constant rates"])
    assert float(one.speed[0]) == pytest.approx(orbit.speed, rel=1e-6)


def test_an_optimised_gait_goes_round() -> None:
    best = rr.optimise(
        FULL, "fastest", offset=(0.0, 3.0), amplitude=0.0, angular_frequency=(1.0, 4.0),
        winding=(1, 1), budget=150, settle_time=10.0,
    )  # fmt: skip
    assert isinstance(best.gait, rr.FourierGait) and best.gait.winding.tolist() == [1, 1]
    assert best.discrepancy < 1e-2
    assert best.search["winding"] == [1, 1]
    assert 0 < best.measured["clearance"] < 0.06


@pytest.mark.parametrize(
    ("gait", "rule"),
    [
        (rr.StillLegs((1.0, 1.0)), "gait 0: the gait has no period"),
        (rr.RampIn(rr.gait("lateral"), 1.0), "second period is not its first"),
        (rr.SinusoidalGait(offset=1.0, amplitude=0.1, angular_frequency=(1.0, 2**0.5)),
         "no common period"),
        (rr.SampledGait(np.linspace(0, 1, 101), np.abs(np.linspace(-1, 1, 101))[:, None] * [1, 1]),
         "harmonics do not give the gait"),
    ],
)  # fmt: skip
def test_what_does_not_repeat_is_refused(gait: rr.Gait, rule: str) -> None:
    with pytest.raises(rr.GaitError, match=rule):
        rr.sweep(FULL, points=[gait])


def test_whole_turns_of_joints_that_turn() -> None:
    with pytest.raises(rr.GaitError, match=r"winding is \[0.5\]: it must hold whole turns"):
        rr.sweep(FULL, winding=[0.5], offset=1.0)
    robot = random_robot(3, joints=6)
    slides = int(np.flatnonzero(lower(rr.FullModel(robot)).tree.prismatic)[0]) - 1
    gait = rr.FourierGait(
        offset=np.zeros(6), cosine=np.zeros((1, 6)), sine=np.zeros((1, 6)),
        angular_frequency=2.0, winding=np.eye(6)[slides],
    )  # fmt: skip
    with pytest.raises(rr.GaitError, match=f"leg {slides + 1} cannot go round"):
        checked(lower(rr.FullModel(robot)).tree, GaitBatch.of([gait]))
