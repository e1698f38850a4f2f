"""MJCF of a robot: MuJoCo reads the same bodies, joints and shell out of it."""

import xml.etree.ElementTree as ET

import numpy as np
import pinocchio as pin
import pytest

import rrrobot as rr
from tests.some import some
from tests.test_belly import board

EXAMPLES = (
    "solo8", "solo12", "anymal", "anymal_c", "a1", "go1", "go2", "b1", "laikago", "hyq", "bolt",
)  # fmt: skip


def test_the_file_is_whole_and_bad_grounds_are_named(tmp_path):
    belly = rr.fit_belly(
        rr.Robot.from_urdf(board(), shell=rr.Sphere(1.0)), ground=rr.Boulder(0.5), posture=-0.1
    )
    text = rr.to_mjcf(belly.robot, tmp_path / "board.xml", ground=belly.ground)
    assert (tmp_path / "board.xml").read_text() == text
    root = ET.fromstring(text)
    (shell,) = root.findall(".//geom[@name='shell']")
    assert shell.get("type") == "box"
    assert [a.get("joint") for a in root.findall("actuator/position")] == list(belly.robot.legs)
    with pytest.raises(rr.ModelError, match="no counterpart"):
        rr.to_mjcf(belly.robot, ground=rr.Boulder(-0.5))
    with pytest.raises(rr.ParameterError, match="friction"):
        rr.to_mjcf(belly.robot, friction=-1)


@pytest.mark.parametrize(
    "shell", [rr.Sphere(0.3), rr.EllipsoidSum([(0.1, 0.1, 0.1), (0.2, 0.1, 0.1)])]
)
def test_mujoco_has_the_same_mass_matrix(shell):
    mujoco = pytest.importorskip("mujoco")
    robot = rr.Robot.from_example("solo12", shell=shell, shell_center=(0.01, 0, 0.2))
    model = mujoco.MjModel.from_xml_string(rr.to_mjcf(robot))
    data = mujoco.MjData(model)
    rng = np.random.default_rng(0)
    q = pin.integrate(robot.model, pin.neutral(robot.model), rng.uniform(-0.7, 0.7, 18))
    joint = [model.joint(leg).qposadr[0] for leg in robot.legs]
    data.qpos[:3], data.qpos[3:7] = q[:3], q[[6, 3, 4, 5]]
    data.qpos[joint] = q[7:]
    mujoco.mj_forward(model, data)
    full = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, full) if _new(mujoco) else mujoco.mj_fullM(model, full, data.qM)
    # MuJoCo's linear velocity of a free joint is the world's, Pinocchio's the base's.
    turn = np.eye(18)
    turn[:3, :3] = pin.Quaternion(q[3:7].copy()).toRotationMatrix().T
    order = [*range(6), *(model.joint(leg).dofadr[0] for leg in robot.legs)]
    wanted = turn.T @ pin.crba(robot.model, robot.model.createData(), q) @ turn
    # Its own armature is none; a thousandth part of balanced inertias is of the file's misprints.
    assert full[np.ix_(order, order)] == pytest.approx(wanted, abs=2e-6)
    center = pin.centerOfMass(robot.model, robot.model.createData(), q)
    assert data.subtree_com[0] == pytest.approx(center, abs=1e-9)
    # The lowest point of the shell is where ours is.
    geom = model.geom("shell")
    assert model.geom_contype[geom.id] == 2


@pytest.mark.parametrize("name", some(EXAMPLES, ("solo8", "anymal_c", "bolt")))
@pytest.mark.filterwarnings("ignore::rrrobot.UrdfWarning")
def test_mujoco_reads_each_example_robot_as_pinocchio_has_it(name):
    """Masses, centres, inertias, joint limits, efforts and the shell, to rounding."""
    mujoco = pytest.importorskip("mujoco")
    shell = rr.Ellipsoid((0.9, 0.7, 0.6))
    robot = rr.Robot.from_example(name, shell=shell, shell_center=(0.01, 0.0, 0.5))
    found = mujoco.MjModel.from_xml_string(rr.to_mjcf(robot))
    for joint in range(1, robot.model.njoints):
        wanted = robot.model.inertias[joint]
        body = found.body(robot.name if joint == 1 else f"{robot.model.names[joint]}_body")
        assert body.mass[0] == pytest.approx(wanted.mass, rel=1e-12)
        assert body.ipos == pytest.approx(wanted.lever, abs=1e-12)
        turn = np.zeros(9)
        mujoco.mju_quat2Mat(turn, body.iquat)
        turn = turn.reshape(3, 3)
        about = turn @ np.diag(body.inertia) @ turn.T
        size = np.abs(wanted.inertia).max()
        assert about == pytest.approx(wanted.inertia, abs=1e-9 * size), name
    limits = robot.joints
    for k, leg in enumerate(robot.legs):
        assert found.joint(leg).range == pytest.approx((limits.lower[k], limits.upper[k]))
        if np.isfinite(limits.effort[k]):
            most = found.actuator(leg).forcerange
            assert most == pytest.approx((-limits.effort[k], limits.effort[k]))
    assert found.geom("shell").size == pytest.approx(shell.semi_axes)
    # Of each link's shapes there is one geom at least, beside the ground and the shell.
    assert found.ngeom == 2 + len(rr.belly.Shapes.of(robot).pieces) and found.nmesh > 0


def _new(mujoco):
    return not hasattr(mujoco.MjData, "qM")
