"""`rrrobot orbit`, `sensitivity`, `continue`, and `sweep --settle orbit`."""

import json

import numpy as np
import pytest
from click.testing import CliRunner

import rrrobot as rr
from rrrobot.cli.main import cli

FULL = rr.FullModel(rr.Robot.from_parameters())


def run(*args):
    return CliRunner().invoke(cli, [str(a) for a in args])


def good(*args):
    result = run(*args)
    assert result.exit_code == 0, result.output
    return result


def test_orbit(tmp_path):
    picture = tmp_path / "cycle.png"
    text = good("orbit", "--gait", "circular", "--plot", picture).stdout
    assert "stable" in text and "6.676" in text and picture.stat().st_size > 10_000
    data = json.loads(good("orbit", "--gait", "circular", "--json").stdout)
    c = rr.limit_cycle(FULL, rr.gait("circular"))
    assert data["speed"] == pytest.approx(c.speed, rel=1e-9)
    assert np.hypot(*data["multipliers"][0]) == pytest.approx(abs(c.multipliers[0]), abs=1e-9)


def test_orbit_of_decoupled_models():
    data = json.loads(good("orbit", "--model", "decoupled", "--gait", "circular", "--json").stdout)
    assert data["yaw_rate"] == pytest.approx(0.01355, rel=1e-3)


def test_orbit_without_damping_is_one_line():
    result = run("orbit", "--damping", "0")
    assert result.exit_code == 1 and "no damping where it rocks" in result.stderr


def test_sensitivity(tmp_path):
    picture = tmp_path / "bars.png"
    text = good("sensitivity", "--gait", "circular", "--of", "yaw_rate", "--plot", picture).stdout
    assert "amplitude[0]" in text and picture.exists()
    data = json.loads(good("sensitivity", "--gait", "circular", "--json").stdout)
    assert {"leg_mass", "amplitude[1]", "damping"} <= {p["name"] for p in data["parameters"]}


def test_continue(tmp_path):
    store, picture = tmp_path / "b.nc", tmp_path / "b.png"
    text = good(
        "continue", "--offset", "pi/2", "--amplitude", 0.3, "--frequency", 5.2, "--phase", 0,
        "--in", "amplitude", "--to", 0.45, "--of", "pitch_amplitude", "--out", store,
        "--plot", picture,
    ).stdout  # fmt: skip
    assert "branch point" in text and "0.404620" in text
    assert store.exists() and picture.exists()
    result = run("continue", "--in", "hat", "--to", 1)
    assert result.exit_code == 1 and "amplitude" in result.stderr


def test_sweep_by_orbits():
    plane = {"offset": np.linspace(0.3, 2.8, 5), "phase_difference": np.linspace(0.4, 5.8, 4)}
    options = {"steps_per_cycle": 20, "progress": False}
    orbits = rr.sweep(FULL, **plane, settle="orbit", loads=True, **options)
    cycles = rr.sweep(FULL, **plane, cycles=90, loads=True, **options)
    assert (orbits.status == 0).all() and orbits.attrs["settle"] == "orbit"
    for name in ("speed", "velocity_x", "velocity_y", "yaw_rate", "roll_amplitude", "roll_mean",
                 "pitch_amplitude", "yaw_amplitude", "rms_torque"):  # fmt: skip
        np.testing.assert_allclose(orbits[name], cycles[name], rtol=1e-6, atol=1e-9, err_msg=name)
    np.testing.assert_allclose(orbits.normal_force, cycles.normal_force, rtol=1e-7)
    one = rr.limit_cycle(FULL, rr.SinusoidalGait(offset=0.3, amplitude=0.3, angular_frequency=8.0,
                                                 phase=(0.0, 0.4)))  # fmt: skip
    assert float(orbits.speed[0, 0]) == pytest.approx(one.speed, rel=1e-7)


def test_an_orbit_that_does_not_hold_is_not_settled():
    """Legs in phase near the pitch's resonance, between the two branch points."""
    grid = {"offset": np.pi / 2, "phase_difference": 0.0, "angular_frequency": 5.2}
    found = rr.sweep(FULL, amplitude=[0.3, 0.5, 0.7], settle="orbit", steps_per_cycle=24,
                     progress=False, **grid)  # fmt: skip
    assert found.status.values.tolist() == [0, 6, 0]
    assert np.isnan(found.speed.values[1])


def test_sweep_by_orbits_refuses():
    with pytest.raises(rr.ModelError, match="no damping"):
        rr.sweep(rr.FullModel(rr.Robot.from_parameters(), damping=None), settle="orbit")
    with pytest.raises(rr.ParameterError, match="settle is 'soon'"):
        rr.sweep(FULL, settle="soon")


def test_sweep_command_by_orbits():
    data = json.loads(
        good("sweep", "--offset", "0.5:1.5:3", "--settle", "orbit", "--json", "--quiet").stdout
    )
    assert data["settle"] == "orbit"
