"""The benchmarks' functions on tiny sizes, and the page that is written from their results."""

import numpy as np
import pytest

from benchmarks import common, engine, report
from benchmarks.common import PAPER_GAITS
from tests.derivations import PointMassRobot, full_model


def true():
    return common.true_motion(PAPER_GAITS.gaits())


@pytest.mark.slow
def test_true_answer_is_that_of_the_reference():
    motion = true()
    np.testing.assert_allclose(motion.speed, (0.009656, 0.0066765), rtol=1e-4)
    np.testing.assert_allclose(motion.yaw_rate, (0.0, 0.0208546), rtol=1e-4, atol=1e-6)


def test_errors_count_what_moves():
    one = common.Motion(np.array([1.0, 1e-5]), np.array([0.0, 1.0]))
    two = common.Motion(np.array([1.1, 1.0]), np.array([1.0, 1.5]))
    found = common.errors(two, one)
    assert found["speed_counted"] == found["yaw_rate_counted"] == 1
    assert found["speed_worst"] == pytest.approx(0.1)
    assert found["yaw_rate_median"] == pytest.approx(0.5)
    assert common.errors(two, common.Motion(np.zeros(2), np.zeros(2)))["speed_worst"] is None


def test_threads_give_the_same_bits():
    setting, gaits = engine.lower(common.full_model()), engine.some_gaits(40, 2)
    one = common.engine(setting, gaits, cycles=3, counted=2)
    np.testing.assert_array_equal(
        one, common.engine(setting, gaits, cycles=3, counted=2, threads=2, chunk=16)
    )


def test_engine_measurements(monkeypatch):
    monkeypatch.setattr(engine, "CYCLES", 3)
    assert engine.linearity((4, 8), 1)[1]["gaits"] == 8
    assert engine.threads(16, 1)["speed_up_best"] > 0
    assert engine.million(32)["stopped"] == 0
    assert engine.first_call()["first_sweep"] > 0


def test_record_names_the_machine_and_no_path(tmp_path):
    with common.recorded("some", tmp_path) as results:
        results["x"] = 1.0
    text = (tmp_path / "some.json").read_text()
    assert "load_average_before" in text and str(common.ROOT) not in text


@pytest.mark.parametrize("form", [pytest.param("constraint", marks=pytest.mark.slow), "kinematics"])
def test_kane_equations_are_those_by_hand(form):
    pytest.importorskip("sympy")
    from benchmarks.kane_peer import equations

    terms, n = equations(form)
    theta, rates = (0.1, 0.2, 0.3), (0.5, -0.4, 0.7)
    phi, phi_dot, phi_ddot = (0.9, 1.3), (1.0, -2.0), (3.0, 4.0)
    hand = full_model(
        PointMassRobot(), theta, rates, phi, phi_dot, phi_ddot, damping=(common.KAPPA,) * 3
    )
    _, pitch, yaw = theta
    along = np.cos(pitch) * rates[0]
    speeds = (
        0.12 * (np.sin(yaw) * along + np.cos(yaw) * rates[1]),
        0.12 * (np.sin(yaw) * rates[1] - np.cos(yaw) * along),
    )[: n - 3]
    constants = (0.12, 0.12, 0.1, 0.3, 0.053, 0.057, 9.81, common.KAPPA)
    flat = np.array(terms(*theta, *rates, *speeds, *phi, *phi_dot, *phi_ddot, *constants))
    found = np.linalg.solve(flat[: n * n].reshape(n, n), flat[n * n :])
    np.testing.assert_allclose(found[:3], hand.theta_ddot, rtol=1e-10)


@pytest.mark.slow
def test_kane_loop_takes_the_means():
    pytest.importorskip("sympy")
    from benchmarks.kane_peer import simulator, starts

    run = simulator("kinematics", compiled=False)
    means = np.empty((2, 2, 3))
    start = starts("kinematics", common.impulsive_rates(PAPER_GAITS))
    run(PAPER_GAITS.offset, PAPER_GAITS.phase, start, 160, means)
    found = common.motion_of_means(means.transpose(1, 0, 2))
    setting, gaits = engine.lower(common.full_model()), PAPER_GAITS.gaits()
    ours = common.engine_motion(common.engine(setting, gaits, cycles=2, counted=2))
    np.testing.assert_allclose(found.speed, ours.speed, rtol=3e-4)
    np.testing.assert_allclose(found.yaw_rate, ours.yaw_rate, rtol=1e-3, atol=1e-4)


@pytest.mark.parametrize("index", range(8))
def test_mujoco_follows_the_robot(index):
    """Over two cycles the contact has no time to lead it astray."""
    pytest.importorskip("mujoco")
    from benchmarks.mujoco_peer import CASES, sweep

    case = CASES[index]
    run = sweep(case, PAPER_GAITS, threads=2, cycles=2, counted=2)
    assert run.leg_error < 1e-5
    damping = common.KAPPA
    if case.free_joint:
        damping = common.rr.BodyRateDamping(*(common.KAPPA,) * 3)
    setting = engine.lower(common.full_model(damping))
    ours = common.engine_motion(common.engine(setting, PAPER_GAITS.gaits(), cycles=2, counted=2))
    loose = 0.6 if "condim 4" in case.name else 0.15
    np.testing.assert_allclose(run.motion.speed, ours.speed, rtol=loose)


def test_mujoco_keeps_energy_where_the_contact_is_stiff():
    pytest.importorskip("mujoco")
    from benchmarks.mujoco_peer import CASES, rocking_loss

    best = next(c for c in CASES if "RK4" in c.name and not c.free_joint)
    assert abs(rocking_loss(best, "roll", duration=3.0)) < 1e-4
    assert rocking_loss(CASES[0], "roll", duration=3.0) > 0.01


def test_page_is_what_the_results_say():
    if not all((common.RESULTS / f"{name}.json").exists() for name in report.FILES):
        pytest.skip("benchmarks have not been run")
    assert report.PAGE.read_text() == report.page(common.RESULTS)
    assert report.README.read_text() == report.readme(common.RESULTS, report.README)


def test_steering_page_is_what_the_results_say():
    from benchmarks import report_steering

    assert report_steering.PAGE.read_text() == report_steering.page()
