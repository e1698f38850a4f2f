"""Models side by side, the modulation of Fig 20, Table 4, and their figures."""

import json

import numpy as np
import pytest
from click.testing import CliRunner

import rrrobot as rr
from rrrobot.cli.main import cli
from rrrobot.figures.comparison import contact_paths, rolling_shell, single_axis
from rrrobot.paper.table4 import PAPER
from rrrobot.simulation.plots import mean_path
from rrrobot.studies.comparison import scaled


@pytest.fixture(scope="module")
def robot():
    return rr.Robot.from_parameters()


@pytest.fixture(scope="module")
def circular(robot):
    """Until it has settled."""
    return rr.studies.compare(robot, rr.gait("circular"))


@pytest.fixture(scope="module")
def short(robot):
    return rr.studies.compare(robot, rr.gait("circular"), 7.0)


@pytest.mark.slow
def test_table_4_of_the_papers_gaits(robot, circular):
    lateral = rr.studies.compare(robot, rr.gait("lateral"))
    assert lateral.ratio("pivoting", "speed") == pytest.approx(1.01, abs=0.005)
    assert lateral.ratio("decoupled", "speed") == pytest.approx(1.0285, abs=0.001)
    assert lateral.ratio("pivoting", "curvature") is None
    assert "modulated" not in lateral.states
    assert circular.ratio("pivoting", "yaw_rate") == pytest.approx(9.486, abs=0.005)
    assert circular.ratio("decoupled", "yaw_rate") == pytest.approx(0.650, abs=0.001)
    assert circular.ratio("modulated", "yaw_rate") == pytest.approx(1.0, abs=1e-6)
    assert circular.ratio("full", "speed") == 1.0


def test_yaw_drift_is_the_simulated_drift(robot):
    gait = rr.gait("circular")
    t = rr.simulate(rr.YawModel(robot), gait, 10.0, rtol=1e-12, atol=1e-13)
    assert rr.studies.yaw_drift(robot, gait) == pytest.approx(t.steady_state().yaw_rate, rel=1e-9)


def test_matching_amplitude_is_fig_20(robot):
    """The factor makes the drift; it falls towards offset pi/2, as the paper's Fig 20 shows."""
    factors = []
    for offset, target in ((np.pi / 6, 0.01767), (np.pi / 4, 0.020855), (np.pi / 3, 0.01727)):
        gait = rr.SinusoidalGait(
            offset=offset, amplitude=0.3, angular_frequency=8.0, phase=(0.0, np.pi / 2)
        )
        factor = rr.studies.matching_yaw_amplitude(robot, gait, target)
        assert rr.studies.yaw_drift(robot, scaled(gait, factor)) == pytest.approx(target, rel=1e-9)
        factors.append(factor)
    assert factors[0] > factors[1] > factors[2] > 1.0
    with pytest.raises(rr.ModelError, match="no leg amplitude"):
        rr.studies.matching_yaw_amplitude(robot, rr.gait("circular"), -0.02)
    with pytest.raises(rr.GaitError, match="period"):
        rr.studies.yaw_drift(robot, rr.StillLegs((1.0, 1.0)))


@pytest.fixture(scope="module")
def plane(robot):
    return rr.paper.table_4(
        robot, offsets=[np.pi / 4, np.pi / 2], phase_differences=[np.pi / 2, 3 * np.pi / 2]
    )


@pytest.mark.slow
def test_plane_equals_single_comparisons(plane, circular):
    """The engine's plane and the KKT comparison are two ways to the same ratios."""
    for model in ("pivoting", "decoupled", "modulated"):
        for quantity in ("speed", "curvature"):
            expected = circular.ratio(model, quantity)
            assert plane.ratio(model, quantity)[0, 0] == pytest.approx(expected, rel=1e-5)
    factor = plane.yaw_amplitude[0, 0] / 0.3
    assert factor == pytest.approx(circular.yaw_amplitude_factor, rel=1e-5)


def test_the_plane_is_symmetric_and_spread_as_the_paper_says(plane):
    # Mirror images in the phase difference turn the other way.
    np.testing.assert_allclose(
        plane.yaw_rate["full"][0, 0], -plane.yaw_rate["full"][0, 1], rtol=1e-6
    )
    assert np.isnan(plane.yaw_amplitude[1]).all()
    spread = plane.spread("pivoting", "curvature")
    assert (
        spread.gaits == 2
        and 8 < spread.lowest <= spread.highest < 10 == PAPER["pivoting"]["curvature"]
    )


def test_plane_of_nothing_is_refused(robot):
    with pytest.raises(rr.ParameterError, match="at least one"):
        rr.paper.table_4(robot, offsets=[], phase_differences=[1.0])


def test_models_that_need_a_sphere_say_so():
    egg = rr.Robot.from_urdf(rr.urdf_path(), shell=rr.Ellipsoid((0.12, 0.12, 0.13)))
    for model in (rr.PivotingModel, rr.RollModel, rr.PitchModel, rr.YawModel):
        with pytest.raises(rr.ModelError, match="spherical shell"):
            model(egg)
    with pytest.raises(rr.ModelError, match="spherical"):
        rr.studies.compare(egg, rr.gait("lateral"), duration=2.0)


def test_figures_show_the_data(short):
    paths = contact_paths(short)
    assert [ax.get_title() for ax in paths.axes] == ["full model", "pivoting model"]
    for ax in paths.axes:
        assert ax.get_xlabel() == "x [cm]" and ax.get_ylabel() == "y [cm]"
    raw = paths.axes[0].lines[0].get_xydata()
    np.testing.assert_array_equal(raw, 100 * short.trajectories["full"].position)
    angles = single_axis(short)
    assert [ax.get_ylabel() for ax in angles.axes[:3]] == [
        "roll [deg]", "pitch [deg]", "yaw [deg]"
    ]  # fmt: skip
    np.testing.assert_allclose(
        angles.axes[1].lines[1].get_ydata(),
        np.rad2deg(short.trajectories["decoupled"].euler[:, 1]),
    )
    shell = rolling_shell(short.trajectories["full"])
    assert shell.axes[0].get_zlabel() == "z [cm]"


def test_mean_path_of_a_known_run(robot):
    """Means over a period at the sample times, of direct integration, after the start."""
    t = rr.simulate(rr.FullModel(robot), rr.gait("circular"), 30.0, method="momentum")
    time, means = mean_path(t)
    assert time[0] == pytest.approx(8 * t.period, abs=t.time[1])
    assert time[-1] == pytest.approx(t.time[-1] - t.period / 2, abs=t.time[1])
    k = 1000
    first = int(np.argmin(np.abs(t.time - time[0])))
    fine = np.linspace(t.time[k] - t.period / 2, t.time[k] + t.period / 2, 4001)
    x = np.interp(fine, t.time, t.position[:, 0])
    assert means[k - first, 0] == pytest.approx(np.trapezoid(x, fine) / t.period, abs=2e-5)


def test_every_models_motion_is_filmed_and_saved(short, tmp_path):
    for name, motion in short.trajectories.items():
        film = rr.record(motion, tmp_path / f"{name}.html")
        assert film.stat().st_size > 100_000
        again = rr.Trajectory.load(motion.save(tmp_path / f"{name}.npz"))
        np.testing.assert_array_equal(again.configuration, motion.configuration)
        assert again.model_name == motion.model_name


@pytest.mark.slow
def test_command_line(tmp_path):
    run = CliRunner().invoke
    result = run(cli, ["compare", "--duration", "8", "--json", "--out", str(tmp_path / "figs")])
    assert result.exit_code == 0, result.output
    data = json.loads(result.stdout)
    assert [row["model"] for row in data["models"]][:3] == ["full", "pivoting", "decoupled"]
    assert sorted(p.name for p in (tmp_path / "figs").iterdir()) == [
        "angles.png", "paths.png", "rolling.png"
    ]  # fmt: skip
    result = run(cli, ["compare", "--plane", "--grid", "2", "3"])
    assert result.exit_code == 0 and "curvature, pivoting" in result.stdout
    result = run(cli, ["periods", "--json"])
    rows = json.loads(result.stdout)
    assert [round(row["linear"], 5) for row in rows] == [1.29251, 1.07346, 1.18804, 0.94509]
    assert "0.96" in run(cli, ["periods"]).stdout
    bad = run(cli, ["compare", "--duration", "-1"])
    assert bad.exit_code == 1 and "duration is -1.0 s" in bad.stderr
