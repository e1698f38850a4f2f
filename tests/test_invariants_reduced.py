"""What the reduced models share: any tree robot, pickling, saving, continuing, refused robots."""

import copy
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from scipy.spatial.transform import Rotation

import rrrobot as rr
from rrrobot.rotations import body_rates_matrix
from tests.twins import UNEQUAL, Array, error, library_robot, random_state, tree_robot

KINDS: tuple[Any, ...] = (rr.PivotingModel, rr.RollModel, rr.PitchModel, rr.YawModel)
every_model = pytest.mark.parametrize("kind", KINDS, ids=lambda k: k.name)
GAIT = rr.gait("circular")


def free_flyer_columns(model: Any, euler: Array) -> Array:
    """Free-flyer base velocities (6, body nv), base frame, of the model's own coordinates."""
    R = np.array(pin.rpy.rpyToMatrix(euler))
    if model.name == "pivoting":
        return np.vstack([np.zeros((3, 3)), body_rates_matrix(*euler[:2])[:, ::-1]])
    turn = np.append(np.zeros(3), np.eye(3)[model.axis])[:, None]
    if model.name == "yaw":
        return turn
    along = np.append(R.T @ np.eye(3)[1 - model.axis], np.zeros(3))[:, None]
    return np.hstack([along, turn])


@every_model
@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("locked", [False, True])
def test_mass_matrix_of_any_tree_robot(kind: Any, seed: int, locked: bool) -> None:
    """That of the free-flyer robot, its base held to the model's freedoms; joints of every kind,
    in another order than Pinocchio's, and with one held at an angle."""
    tree = tree_robot(seed, centred=True)
    names, held = ["joint3", "joint1", "joint2", "joint0"], {}
    if locked:
        names, held = ["joint3", "joint1"], {"joint0": 0.7, "joint2": 0.03}
    robot = rr.Robot.from_urdf(tree.urdf, shell=tree.shell, legs=names, locked=held)
    model = kind(robot)
    rng = np.random.default_rng(seed)
    euler = rng.uniform(-1, 1, 3) * [i in model.axes for i in range(3)]
    legs = rng.uniform(-2, 2, len(names))
    pose = model.make_pose(euler, np.zeros(2))

    whole = rr.FullModel(robot)
    mass = whole.mass_matrix(whole.make_pose(euler, np.zeros(2)), legs)
    body = model.model.nv - len(names)
    columns = np.zeros((whole.model.nv, model.model.nv))
    columns[:6, :body] = free_flyer_columns(model, euler)
    columns[whole.legs.v, model.legs.v] = 1.0
    assert error(model.mass_matrix(pose, legs), columns.T @ mass @ columns) < 1e-12


@every_model
@pytest.mark.parametrize(
    "damping", [None, rr.EulerRateDamping(0.1, 0.2, 0.3, legs=0.4), rr.BodyRateDamping(0.1, y=0.2)]
)
def test_models_pickle_and_copy(kind: Any, damping: Any) -> None:
    model = kind(library_robot(UNEQUAL), damping=damping)
    state = random_state(np.random.default_rng(0))
    pose = model.make_pose(state.theta, np.ones(2))
    quasi = np.arange(1.0, 1.0 + model.n_quasi)
    before = model.dynamics(pose, quasi, state.leg)
    for again in (pickle.loads(pickle.dumps(model)), copy.deepcopy(model)):
        assert type(again) is kind and again is not model
        assert again.robot == model.robot and again.damping == model.damping
        assert repr(again) == repr(model) and again.to_dict() == model.to_dict()
        after = again.dynamics(pose, quasi, state.leg)
        for found, expected in zip(after, before, strict=True):
            if isinstance(expected, dict):
                assert {k: a.tolist() for k, a in found.items()} == {
                    k: a.tolist() for k, a in expected.items()
                }
            else:
                assert np.array_equal(found, expected)


@every_model
def test_trajectories_pickle_and_save(kind: Any, tmp_path: Path) -> None:
    t = rr.simulate(kind(library_robot(UNEQUAL)), GAIT, 0.3)
    loaded = rr.Trajectory.load(t.save(tmp_path / "t.npz"))
    for again in (pickle.loads(pickle.dumps(t)), loaded):
        for name, value in vars(t).items():
            if isinstance(value, np.ndarray):
                assert np.array_equal(getattr(again, name), value), name
        assert again.robot == t.robot and again.metadata == t.metadata
        assert again.model_name == kind.name and again.period == GAIT.period


@every_model
def test_the_replayed_motion_turns_as_the_angles_say(kind: Any) -> None:
    """The free-flyer q and v, which the viewer and Pinocchio replay."""
    t = rr.simulate(kind(library_robot(UNEQUAL)), GAIT, 1.0, 0.1, position=(0.2, 0.1))
    assert np.ptp(t.euler[:, kind.axes], axis=0).min() > 0.01
    for i in range(len(t)):
        turn = Rotation.from_euler("ZYX", t.euler[i, ::-1])
        found = Rotation.from_quat(t.configuration[i, 3:7])
        assert (found * turn.inv()).magnitude() < 1e-14
        omega = body_rates_matrix(*t.euler[i, :2]) @ t.euler_rates[i]
        assert t.velocity[i, 3:6] == pytest.approx(omega, abs=1e-14)
    assert t.configuration[:, :2] == pytest.approx(t.position, abs=1e-15)
    assert np.array_equal(t.configuration[:, 7:], t.leg_angle)
    assert np.array_equal(t.velocity[:, 6:], t.leg_rate)


@every_model
def test_a_feedback_law_sees_the_motion(kind: Any) -> None:
    free = np.array([i in kind.axes for i in range(3)])
    euler, rates = free * (0.3, -0.4, 0.5), free * (1.0, 2.0, -1.5)
    seen: list[rr.drive.MotionState] = []

    def law(state: rr.drive.MotionState) -> Array:
        seen.append(state)
        return np.zeros(2)

    drive = rr.LegTorques(law, angle=(0.5, 0.6), rate=(0.7, 0.8), feedback=True)
    model = kind(library_robot())
    rr.simulate(model, drive, 0.01, euler=euler, start=rates, position=(0.1, 0.2))
    first = seen[0]
    turn = Rotation.from_euler("ZYX", euler[::-1]).as_matrix()
    assert first.R_world_body == pytest.approx(turn, abs=1e-15)
    omega = body_rates_matrix(*euler[:2]) @ rates
    assert first.omega_body == pytest.approx(omega, abs=1e-15)
    assert first.position.tolist() == [0.1, 0.2]
    assert first.leg_angle.tolist() == [0.5, 0.6] and first.leg_rate.tolist() == [0.7, 0.8]


@every_model
def test_a_state_continues_a_simulation(kind: Any) -> None:
    model = kind(library_robot(UNEQUAL))
    legs = rr.StillLegs((0.3, 0.9))
    start = np.array([1.0, 0.5, 2.0]) * [i in model.axes for i in range(3)]
    whole = rr.simulate(model, legs, 1.0, start=start, position=(0.5, 0.5))
    first = rr.simulate(model, legs, 0.4, start=start, position=(0.5, 0.5))
    second = rr.simulate(model, legs, 0.6, state=first.final_state)
    assert np.ptp(whole.euler[:, model.axes[0]]) > 0.1
    assert np.abs(second.state - whole.state[40:]).max() < 1e-8
    assert np.abs(second.position - whole.position[40:]).max() < 1e-9


@every_model
def test_only_rolling_models_have_a_contact(kind: Any) -> None:
    t = rr.simulate(kind(library_robot()), rr.gait("lateral"), 0.2)
    if kind in (rr.RollModel, rr.PitchModel):
        assert t.has_contact and np.all(t.required_friction < 1)
    else:
        assert not t.has_contact and t.lift_off_time is None
        with pytest.raises(rr.ModelError, match="pivoted: it has no contact"):
            _ = t.required_friction


def urdf_robot(**options: Any) -> rr.Robot:
    return rr.Robot.from_urdf(rr.urdf_path(), **({"shell": rr.Sphere(0.12)} | options))


def test_robots_that_do_not_fit_are_refused() -> None:
    robot = urdf_robot(shell=rr.Ellipsoid((0.12, 0.12, 0.13)))
    message = "needs a spherical shell; this robot has"
    for kind in KINDS:
        with pytest.raises(rr.ModelError, match=f"the {kind.name} model .*{message}"):
            kind(robot)
    with pytest.raises(rr.ModelError, match=message):
        rr.decoupled(robot, GAIT, 1.0)
    for kind in KINDS:
        assert kind(urdf_robot()).radius == 0.12
        with pytest.raises(rr.ModelError, match=rf"the {kind.name} model needs level ground, not"):
            kind(urdf_robot(), ground=rr.Plane((0.1, 0.0, 1.0)))
