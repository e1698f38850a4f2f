"""Several starts: mirrored motions, doubled ones, and what does not repeat."""

import json

import numpy as np
import pytest
from click.testing import CliRunner

import rrrobot as rr
from rrrobot.cli.main import cli

ROBOT = rr.Robot.from_parameters()
FULL = rr.FullModel(ROBOT)


def in_phase(amplitude, omega):
    return rr.SinusoidalGait(offset=np.pi / 2, amplitude=amplitude, angular_frequency=omega)


def test_two_mirrored_motions():
    """Legs in phase beyond the loss of symmetry: one turns to the left, one to the right."""
    found = rr.orbits.attractors(FULL, in_phase(0.45, 5.2), n_starts=16)
    assert len(found) == 2 and found.elsewhere <= 1 / 16 and found.lost == 0
    one, two = found
    assert one.stable and two.stable and one.periods == 1
    assert one.yaw_rate == pytest.approx(-two.yaw_rate, rel=1e-9)
    assert one.speed == pytest.approx(two.speed, rel=1e-8) and one.speed > 3e-4
    assert found.share.sum() + found.elsewhere == 1.0


def test_a_motion_of_two_periods_counts_once():
    """Whichever of its two periods a start comes to the beginning of."""
    model = rr.RollModel(ROBOT, damping=0.003)
    omega = 1.04 * 4 * np.pi / rr.orbits.modes(model, (0.0, 0.0))[0].period
    gait = rr.SinusoidalGait(offset=0.0, amplitude=0.35, angular_frequency=omega)
    found = rr.orbits.attractors(model, gait, n_starts=12)
    assert [c.periods for c in found] == [2]
    assert found.share[0] == 11 / 12  # the upright start stays upright, which does not hold


def test_runs_from_the_starts_come_to_them():
    """By the KKT form, from a start near each motion of three."""
    gait = in_phase(0.7, 5.4)
    found = rr.orbits.attractors(FULL, gait, n_starts=24, seed=3)
    assert len(found) >= 3
    still = min(found, key=lambda c: abs(c.yaw_rate))
    turning = max(found, key=lambda c: c.yaw_rate)
    assert abs(still.yaw_rate) < 1e-9 and turning.yaw_rate > 0.5
    start = turning.euler + np.array((0.01, -0.01, 0.0))
    run = rr.simulate(FULL, gait, 20 * turning.period, turning.period / 24, euler=start,
                      start=turning.euler_rates)  # fmt: skip
    state = run.steady_state(after=16 * turning.period)
    assert state.yaw_rate == pytest.approx(turning.yaw_rate, rel=1e-2)


def test_bad_input():
    gait = in_phase(0.3, 8.0)
    with pytest.raises(rr.ParameterError, match="n_starts is 0"):
        rr.orbits.attractors(FULL, gait, n_starts=0)
    with pytest.raises(rr.ModelError, match="no damping"):
        rr.orbits.attractors(rr.FullModel(ROBOT, damping=None), gait)
    with pytest.raises(rr.OrbitError, match="all of 4 starts tip over"):
        rr.orbits.attractors(FULL, in_phase(2.5, 6.44), n_starts=4)


@pytest.mark.usefixtures("compiled_engine")
def test_command():
    args = ("--offset", "pi/2", "--amplitude", "0.45", "--frequency", "5.2", "--phase", "0")
    result = CliRunner().invoke(cli, ["orbit", *args, "--starts", "8", "--json"])
    assert result.exit_code == 0, result.output
    data = json.loads(result.stdout)
    assert len(data["cycles"]) == 2
    table = CliRunner().invoke(cli, ["orbit", *args, "--starts", "8"]).stdout
    assert "period 1, " in table and "do not repeat" in table
