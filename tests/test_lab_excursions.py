"""The laboratory's other motions, and what is taken home."""

from dataclasses import replace

import numpy as np
import pytest

import rrrobot as rr
from rrrobot.lab.excursions import driven, pushed, rocking, sent
from rrrobot.lab.home import FILES, code
from rrrobot.lab.knobs import Knobs
from rrrobot.lab.outcome import Refusal, settle
from rrrobot.lab.tabs import on_ground

ROBOT = rr.Robot.from_parameters()
KNOBS = Knobs.of(ROBOT)


@pytest.fixture(scope="module")
def circular():
    return settle(ROBOT, KNOBS)


def test_a_push_dies_away_as_the_multipliers_say(circular):
    t = pushed(ROBOT, circular, (0.5, 0.0, 0.0)).trajectory
    assert t.euler_rates[0] == pytest.approx(
        circular.cycle.euler_rates + np.array((0.5, 0, 0)), abs=1e-9
    )
    # Roll and pitch at the same phase of the legs; heading and place stay where they came to.
    away = np.linalg.norm(t.euler[::36, :2] - circular.cycle.euler[:2], axis=1)
    assert away[2] > 1e-4
    falls = (away[9] / away[3]) ** (1 / 6)
    assert falls == pytest.approx(abs(circular.multipliers[0]), rel=0.25)
    assert away[-1] < 1e-2 * away.max()
    with pytest.raises(Refusal, match="repeats"):
        pushed(ROBOT, replace(circular, cycle=None), (1.0, 0.0, 0.0))


def test_rocking_has_the_period_of_the_linearised_motion():
    upright = replace(KNOBS, offset=(np.pi / 2, np.pi / 2), damping=1e-4)
    t = rocking(ROBOT, upright, (0.02, 0.0)).trajectory
    roll = t.euler[:, 0]
    up = np.flatnonzero((roll[:-1] < 0) & (roll[1:] >= 0))
    at = t.time[up] - roll[up] * np.diff(t.time)[up] / np.diff(roll)[up]
    model = upright.model(ROBOT)
    frequencies = np.array([abs(m.eigenvalue.imag) for m in rr.modes(model, (np.pi / 2,) * 2)])
    found = 2 * np.pi / np.diff(at).mean()
    assert np.abs(frequencies - found).min() < 2e-3 * found


@pytest.mark.slow
def test_stiff_motors_follow_the_gait():
    """Legs that follow the gait exactly, from the same start, are where motors come to."""
    apart = []
    for stiffness in (3.0, 12.0):
        found = driven(ROBOT, KNOBS, stiffness, stiffness / 30)
        t = found.trajectory
        same = rr.simulate(
            KNOBS.model(ROBOT), KNOBS.gait(), float(t.time[-1]), float(t.time[1]), method="momentum"
        )
        # Where a leg is farthest behind, its rate is the gait's: the stiffness gives the torque.
        assert np.abs(t.leg_angle - same.leg_angle).max() <= found.torque / stiffness
        assert found.torque == pytest.approx(np.abs(same.leg_torque).max(), rel=1e-3)
        assert found.speed == pytest.approx(same.steady_state().speed, rel=0.03 / stiffness)
        apart.append(np.abs(t.position - same.position).max())
    assert apart[1] < 0.3 * apart[0] < 3e-4
    with pytest.raises(Refusal, match="interrupted"):
        driven(ROBOT, KNOBS, 3.0, 0.1, lambda: True)


@pytest.mark.slow
def test_going_there_arrives():
    found = sent(ROBOT, KNOBS, (0.1, 0.1, 0.5))
    assert found.trajectory.position[-1] == pytest.approx((0.1, 0.1), abs=1e-3)
    assert found.trajectory.euler[-1, 2] % (2 * np.pi) == pytest.approx(0.5, abs=4e-3)
    assert any("arrives" in word for word in found.words)


def test_a_click_on_the_ground_is_where_its_ray_meets_it():
    eye, place = np.array((0.3, -1.0, 2.0)), np.array((0.5, 0.25, 0.0))
    assert on_ground(eye, place - eye) == pytest.approx(place[:2])
    assert on_ground(eye, (1.0, 0.0, 0.1)) is None


@pytest.mark.filterwarnings("ignore::rrrobot.UnsettledWarning")  # of eight seconds
def test_the_code_and_the_files_are_the_motion(circular, tmp_path):
    knobs = replace(KNOBS, gravity=5.0, overtone=((0.05, 0.0), (0.0, 0.0)))
    space: dict = {}
    exec(code(ROBOT, knobs).replace("duration=30.0", "duration=8.0"), space)
    assert space["model"].to_dict() == knobs.model(ROBOT).to_dict()
    assert space["robot"] == knobs.robot(ROBOT)
    times = np.linspace(0, 1, 7)
    assert space["gait"](times).angle == pytest.approx(knobs.gait()(times).angle, abs=0)
    made = {name: make(circular) for name, make in FILES.values()}
    for name, content in made.items():
        (tmp_path / name).write_bytes(content)
    assert rr.read_gait(tmp_path / "gait.json").to_dict() == KNOBS.gait().to_dict()
    loaded = rr.Trajectory.load(tmp_path / "trajectory.npz")
    assert loaded.position[:36] == pytest.approx(circular.path()[:36], abs=1e-9)
    assert b"meshcat" in made["film.html"].lower()


@pytest.mark.filterwarnings("ignore::rrrobot.UnsettledWarning")  # of four seconds
def test_the_code_of_a_robot_of_a_file_runs_beside_its_trajectory(tmp_path, monkeypatch):
    robot = rr.Robot.from_urdf(rr.urdf_path("rrrobot"), shell=rr.Sphere(0.12))
    knobs = replace(Knobs.of(robot), offset=(0.7, 0.8), gravity=5.0)
    runs_beside_its_trajectory(robot, knobs, 4.0, tmp_path, monkeypatch)


def runs_beside_its_trajectory(robot, knobs, duration, folder, monkeypatch):
    """The copied script, where the page's trajectory was saved, makes the page's motion."""
    found = settle(robot, knobs)
    name, make = FILES["trajectory (.npz)"]
    (folder / name).write_bytes(make(found))
    monkeypatch.chdir(folder)
    space: dict = {}
    exec(code(robot, knobs).replace("duration=30.0", f"duration={duration}"), space)
    assert space["model"].to_dict() == knobs.model(robot).to_dict()
    cycle = rr.limit_cycle(space["model"], space["gait"])
    assert cycle.speed == pytest.approx(found.speed, rel=1e-6)
