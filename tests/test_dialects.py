"""Robot files as people have them: what is read, as what, and what is refused or told.

Every robot read is compared with one written by hand, or with Pinocchio's own reading.
"""

import warnings

import numpy as np
import pinocchio as pin
import pytest

import rrrobot as rr
from rrrobot.robot.reader import parse_urdf
from tests.mechanisms import joint, link
from tests.random_robot import random_urdf

SHELL = rr.Sphere(0.3)


def body(mass=1, moment=0.01, z=0.0):
    return (
        f'<inertial><origin xyz="0 0 {z}"/><mass value="{mass}"/><inertia ixx="{moment}" ixy="0" '
        f'ixz="0" iyy="{moment}" iyz="0" izz="{moment}"/></inertial>'
    )


BODY = body()
LINK = f'<link name="b">{BODY}</link>'


def leg(name="hip", parent="b", kind="continuous", more=""):
    return (
        f'<link name="{name}_link">{BODY}</link><joint name="{name}" type="{kind}">'
        f'<parent link="{parent}"/><child link="{name}_link"/><axis xyz="0 1 0"/>'
        f'<limit effort="2" velocity="3" lower="-1" upper="1"/>{more}</joint>'
    )


def read(text, **options):
    return rr.Robot.from_urdf(text, shell=SHELL, **options)


# Lenient XML

LENIENT = {
    "comment with --": f'<robot name="r"><!-- old -- one -->{LINK}</robot>',
    "comment in a comment": f'<robot name="r"><!--joint> <!-- note -->{LINK}</robot>',
    "comment of dashes": f'<robot name="r"><!------- a -------->{LINK}</robot>',
    "blank line first": f'\n \n<?xml version="1.0"?><robot name="r">{LINK}</robot>',
    "a mark, then a blank": f'\ufeff \n<?xml version="1.0"?>\n<robot name="r">{LINK}</robot>',
    "comment first": f'<!-- a -- b -->\n<?xml version="1.0"?><robot name="r">{LINK}</robot>',
    "prefix without xmlns": f'<robot name="r">{LINK}<drake:proximity_properties/></robot>',
    "default namespace": f'<robot xmlns="http://drake.mit.edu" name="r">{LINK}</robot>',
    "material twice": f'<robot name="r"><material name="k"/><material name="k"/>{LINK}</robot>',
    "an encoding said": f'<?xml version="1.0" encoding="us-ascii"?><robot name="r">{LINK}</robot>',
}  # fmt: skip


@pytest.mark.parametrize("name", LENIENT)
def test_lenient_xml(name, capfd):
    robot = read(LENIENT[name])
    assert robot.mass == 1.0
    assert capfd.readouterr().err == ""


def test_a_comment_hides_what_it_holds():
    robot = read(f'<robot name="r"><!-- a -- {leg("no")} -->{LINK}{leg("hip")}</robot>')
    assert robot.legs == ("hip",)


@pytest.mark.parametrize("xyz", ["0.1,0.2,0.3", "0.1, 0.2 ,0.3", "0.1, 0.2 0.3"])
def test_commas_in_vectors(xyz):
    text = f'<robot name="r">{LINK}{leg(more=f"""<origin xyz="{xyz}"/>""")}</robot>'
    assert read(text).model.jointPlacements[2].translation.tolist() == [0.1, 0.2, 0.3]


def test_all_faults_are_told_at_once_with_their_lines():
    text = (
        '<robot name="r">\n<link name="b"><inertial><mass value="-1"/></inertial></link>\n\n'
        '<link name="c"/>\n<joint name="j" type="hinge">\n<origin xyz="a b c"/>'
        '<parent link="b"/><child link="d"/></joint></robot>'
    )
    with pytest.raises(rr.UrdfError) as caught:
        read(text)
    message = str(caught.value)
    assert message.startswith("the URDF has 4 faults: ")
    for part in (
        "<mass value='-1'> of link 'b' must not be negative (line 2).",
        "the type 'hinge'", "(line 5)", "<origin xyz='a b c'> of joint 'j' is not numeric",
        "(line 6)", "child link 'd'",
    ):  # fmt: skip
        assert part in message


def test_lines_are_the_files_whatever_stands_before():
    text = f'\n\n<!-- \n -- \n-->\n<robot name="r">{LINK}\n<link name="b"/></robot>'
    with pytest.raises(rr.UrdfError, match=r"unique and not empty: b \(line 7\)\."):
        read(text)


# Other formats

XACRO = f"""<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">
<xacro:property name="m" value="0.5"/>{LINK.replace('"1"', '"${2*m}"')}
<xacro:macro name="leg" params="n">{leg("hip_${n}")}</xacro:macro>
<xacro:leg n="1"/><xacro:leg n="2"/></robot>"""


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ('<sdf version="1.6"/>', "the file is an SDF file, not a URDF"),
        ('<mujoco model="m"/>', "the file is an MJCF file of MuJoCo, not a URDF"),
        ("<html/>", "root element is <html>: a URDF starts with <robot>"),
    ],
)
def test_other_formats_are_named(text, says):
    with pytest.raises(rr.UrdfError, match=says):
        read(text)


@pytest.mark.parametrize(
    "text",
    [
        XACRO,
        f'<robot name="r" xmlns:xacro="http://x"><xacro:include filename="l.xacro"/>{LINK}</robot>',
        f'<robot name="r"><xacro:leg/>{LINK}</robot>',
        f'<robot name="r" xmlns:x="http://www.ros.org/xacro"><x:leg/>{LINK}</robot>',
        f'<robot name="r">{LINK}<link name="${{n}}"/></robot>',
    ],
)
def test_unexpanded_xacro_is_refused_without_the_package(text, monkeypatch):
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(rr.UrdfError, match=r"unexpanded xacro \(.* at line \d+\): run `xacro "):
        read(text)


def test_xacro_is_expanded_with_the_package(tmp_path):
    pytest.importorskip("xacro")
    (tmp_path / "legs.xacro").write_text(
        f'<robot xmlns:xacro="http://www.ros.org/wiki/xacro">{leg("hip_3")}</robot>'
    )
    path = tmp_path / "r.urdf.xacro"
    path.write_text(XACRO.replace("</robot>", '<xacro:include filename="legs.xacro"/></robot>'))
    robot = read(path)
    assert robot.legs == ("hip_1", "hip_2", "hip_3")
    assert robot.mass == pytest.approx(4.0)
    path.write_text(XACRO.replace("2*m", "2*none"))
    with pytest.raises(rr.UrdfError, match=r"xacro .* that cannot be expanded"):
        read(path)


# The base

FLOATING = (
    f'<robot name="r"><link name="world"/>{LINK}<joint name="float" type="{{}}"><parent '
    f'link="world"/><child link="b"/><origin xyz="0 0 0.5"/></joint>{leg()}</robot>'
)


@pytest.mark.parametrize("kind", ["floating", "fixed"])
def test_the_worlds_own_joint_is_the_free_flyer(kind):
    robot, plain = read(FLOATING.format(kind)), read(f'<robot name="r">{LINK}{leg()}</robot>')
    assert robot.legs == ("hip",)
    assert robot.shell_link == "b"
    assert robot.shell_placement.isIdentity()
    q = pin.neutral(plain.model)
    q[7:] = np.cos(0.3), np.sin(0.3)
    one, other = (pin.crba(r.model, r.model.createData(), q) for r in (robot, plain))
    assert np.array_equal(one, other)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ('name="world"', 'name="stand"'),
        ('<link name="world"/>', f'<link name="world">{BODY}</link>'),
    ],
)
def test_other_fixed_roots_stay(old, new):
    text = FLOATING.format("fixed").replace(old, new)
    if "stand" in new:
        text = text.replace('link="world"', 'link="stand"')
    assert read(text).shell_link in ("world", "stand")


def test_a_floating_joint_elsewhere_is_refused():
    with pytest.raises(rr.UrdfError, match="'hip' has 6 degrees of freedom"):
        read(f'<robot name="r">{LINK}{leg(kind="floating")}</robot>')


@pytest.mark.parametrize("kind", ["ball", "spherical"])
def test_a_ball_joint_is_three_revolutes(kind):
    """Any rotation of the leg can be reached, about one point, with the masses as written."""
    text = f'<robot name="r">{LINK}{leg(kind=kind, more="""<origin xyz="0 0 0.2"/>""")}</robot>'
    robot = read(text)
    assert robot.legs == ("hip_x", "hip_y", "hip_z")
    assert robot.mass == 2.0
    model = robot.model
    q = np.concatenate(
        (pin.neutral(model)[:7], *((np.cos(a), np.sin(a)) for a in (0.3, -0.4, 0.5)))
    )
    data = model.createData()
    pin.forwardKinematics(model, data, q)
    placed = data.oMi[model.getJointId("hip_z")]
    rx, ry, rz = (pin.utils.rotate(a, x) for a, x in zip("xyz", (0.3, -0.4, 0.5), strict=True))
    assert placed.rotation == pytest.approx(rx @ ry @ rz, abs=1e-15)
    assert placed.translation == pytest.approx((0, 0, 0.2), abs=1e-15)
    pin.crba(model, data, q)
    assert np.linalg.eigvalsh(data.M).min() > 1e-4


# The shell on any link


def rooted_pair(seed, link_name):
    """A random tree as written, and turned over at a link."""
    text = random_urdf(seed)
    return rr.Robot.from_urdf(text, shell=SHELL), rr.Robot.from_urdf(
        text, shell=SHELL, shell_link=link_name
    )


@pytest.mark.parametrize("seed", range(4))
def test_turned_over_tree_is_the_same_mechanism(seed):
    """Kinetic energy, potential energy and every link's place are those of the tree as written."""
    from rrrobot.robot.faults import root_link
    from rrrobot.robot.tree import path_down

    text = random_urdf(seed)
    tree = parse_urdf(text)
    deep = max(
        (str(e.get("name")) for e in tree.findall("link")), key=lambda n: len(path_down(tree, n))
    )
    assert len(path_down(tree, deep)) >= 2
    plain = rr.Robot.from_urdf(text, shell=SHELL)
    turned = rr.Robot.from_urdf(text, shell=SHELL, shell_link=deep, legs=plain.legs)
    assert turned.mass == pytest.approx(plain.mass, rel=1e-14)
    assert turned.model.frames[turned.model.getFrameId(deep, pin.FrameType.BODY)].parentJoint == 1
    rng = np.random.default_rng(seed)
    angle, rate = rng.normal(size=(2, plain.n_legs))
    from rrrobot.robot.joints import JointIndex

    m, t = plain.model, turned.model
    q, v = pin.randomConfiguration(m, -np.ones(m.nq), np.ones(m.nq)), rng.normal(size=m.nv)
    q[3:7] /= np.linalg.norm(q[3:7])
    index = JointIndex(m, plain.legs)
    index.write(q, angle)
    v[index.v] = rate
    data = m.createData()
    pin.forwardKinematics(m, data, q, v)
    pin.updateFramePlacements(m, data)
    frame = m.getFrameId(deep, pin.FrameType.BODY)
    base = data.oMf[frame]
    twist = pin.getFrameVelocity(m, data, frame, pin.ReferenceFrame.LOCAL)
    qt, vt = pin.neutral(t), np.zeros(t.nv)
    # The base's frame is the link's own.
    qt[:7] = pin.SE3ToXYZQUAT(base)
    vt[:6] = twist.vector
    other = JointIndex(t, turned.legs)
    other.write(qt, angle)
    vt[other.v] = rate
    again = t.createData()
    pin.framesForwardKinematics(t, again, qt)
    for name in (str(e.get("name")) for e in tree.findall("link")):
        one = data.oMf[m.getFrameId(name, pin.FrameType.BODY)]
        two = again.oMf[t.getFrameId(name, pin.FrameType.BODY)]
        assert one.homogeneous == pytest.approx(two.homogeneous, abs=1e-12), name
    assert pin.computeKineticEnergy(t, again, qt, vt) == pytest.approx(
        pin.computeKineticEnergy(m, data, q, v), rel=1e-11
    )
    assert pin.computePotentialEnergy(t, again, qt) == pytest.approx(
        pin.computePotentialEnergy(m, data, q), rel=1e-11
    )
    # The work of the joints: the same efforts give the same accelerations of the joints.
    tau = np.zeros(m.nv)
    tau[index.v] = rng.normal(size=plain.n_legs)
    tau_turned = np.zeros(t.nv)
    tau_turned[other.v] = tau[index.v]
    a = pin.aba(m, data, q, v, tau)[index.v]
    assert pin.aba(t, again, qt, vt, tau_turned)[other.v] == pytest.approx(a, rel=1e-8)
    assert root_link(parse_urdf(turned.rooted_urdf)) == deep


def ball_and_pendulum(root):
    ball = f'<link name="ball">{body(16.5, 0.64)}</link>'
    pendulum = f'<link name="pendulum">{body(24.8, 0.5, -0.09)}</link>'
    ends = ("ball", "pendulum", 1) if root == "ball" else ("pendulum", "ball", -1)
    return (
        f'<robot name="r">{ball}{pendulum}<joint name="drive" type="continuous"><parent '
        f'link="{ends[0]}"/><child link="{ends[1]}"/><axis xyz="0 {ends[2]} 0"/></joint></robot>'
    )


def test_a_ball_below_its_pendulum_rolls_as_one_written_from_the_ball():
    def run(root, **options):
        robot = rr.Robot.from_urdf(ball_and_pendulum(root), shell=rr.Sphere(0.305), **options)
        push = rr.LegTorques((2.0,), angle=(0.0,))
        return rr.simulate(rr.FullModel(robot, damping=None), push, 1.0, start="rest")

    by_hand, turned = run("ball"), run("pendulum", shell_link="ball")
    assert turned.position == pytest.approx(by_hand.position, abs=1e-12)
    assert turned.leg_angle == pytest.approx(by_hand.leg_angle, abs=1e-12)
    assert abs(by_hand.position[-1, 0]) > 0.05
    with pytest.warns(rr.UrdfWarning, match="link 'ball', which moves .* shell_link='ball'"):
        rr.Robot.from_urdf(ball_and_pendulum("pendulum"), shell=rr.Sphere(0.305))


def test_a_locked_joint_does_not_turn_the_tree_over():
    robot = rr.Robot.from_urdf(
        ball_and_pendulum("pendulum"), shell=rr.Sphere(0.305), shell_link="ball", legs=()
    )
    assert robot.rooted_urdf.index("<robot") == 0
    assert robot.locked == {"drive": 0.0}
    assert robot.model.nv == 6


def test_reduced_models_of_a_turned_tree():
    one, other = (
        rr.PivotingModel(
            rr.Robot.from_urdf(ball_and_pendulum(r), shell=rr.Sphere(0.3), shell_link="ball")
        )
        for r in ("ball", "pendulum")
    )
    pose = one.make_pose((0.1, 0.2, 0.3), (0, 0))
    assert one.mass_matrix(pose, (0.4,)) == pytest.approx(
        other.mass_matrix(pose, (0.4,)), abs=1e-12
    )


# What the joints say


def heavy(dynamics):
    """A wheel of 0.01 kg m^2 on a body that nothing moves."""
    text = (
        f'<robot name="r"><link name="body">{body(1e6, 1e6)}</link><link name="wheel">'
        f'{body(0.1, 0.01)}</link><joint name="j" type="continuous"><parent link="body"/>'
        f'<child link="wheel"/><axis xyz="0 1 0"/>{dynamics}</joint></robot>'
    )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", rr.UrdfWarning)
        return rr.Robot.from_urdf(text, shell=rr.Sphere(0.2))


def test_joint_damping_slows_a_torque_driven_leg():
    """Of a body too heavy to move, the rate decays as exp(-d t / I)."""
    robot = heavy('<dynamics damping="0.5"/>')
    assert robot.joints.damping.tolist() == [0.5]
    free = rr.LegTorques((0.0,), angle=(0.0,), rate=(10.0,))
    t = rr.simulate(rr.FullModel(robot, damping=None), free, 0.1, start="rest")
    assert t.leg_rate[:, 0] == pytest.approx(10 * np.exp(-50 * t.time), rel=1e-4, abs=1e-4)


def test_joint_friction_stops_a_torque_driven_leg():
    """Coulomb's: the rate falls by f / I each second, to a stop."""
    robot = heavy('<dynamics friction="0.2"/>')
    free = rr.LegTorques((0.0,), angle=(0.0,), rate=(10.0,))
    t = rr.simulate(rr.FullModel(robot, damping=None), free, 0.7, start="rest")
    assert t.leg_rate[:, 0] == pytest.approx(np.maximum(10 - 20 * t.time, 0), abs=2e-2)


def test_motors_overcome_both_and_the_motion_is_the_same():
    gait = rr.SinusoidalGait(offset=(0.5,), amplitude=(0.4,), angular_frequency=6.0, phase=(0.0,))
    robots = heavy(""), heavy('<dynamics damping="0.5" friction="0.2"/>')
    plain, lossy = (rr.simulate(rr.FullModel(r, damping=None), gait, 1.0) for r in robots)
    assert np.array_equal(plain.state, lossy.state)
    rate = lossy.leg_rate
    more = 0.5 * rate + 0.2 * np.tanh(rate / 0.01)
    assert lossy.leg_torque - plain.leg_torque == pytest.approx(more, abs=1e-12)


def test_sweeps_count_joint_losses_among_the_torques():
    robots = heavy(""), heavy('<dynamics damping="0.5" friction="0.2"/>')
    options = dict(offset=0.5, amplitude=0.4, angular_frequency=6.0, loads=True, progress=False)
    plain, lossy = (
        rr.sweep(rr.FullModel(r, damping=rr.BodyRateDamping(1, 1, 1)), **options) for r in robots
    )
    rate = 2.4 * np.cos(np.linspace(0, 2 * np.pi, 100_000, endpoint=False))
    own = np.mean(np.abs(rate * (0.5 * rate + 0.2 * np.tanh(rate / 0.01))))
    # Inertial and friction power: |a + b| averages to the sum only where signs agree.
    assert float(lossy.power) >= own * (1 - 1e-3)
    assert float(lossy.peak_torque) > float(plain.peak_torque)


def test_what_nobody_models_is_told_once():
    more = '<dynamics damping="1" K="3"/><axis xyz="1 0 0"/>'
    text = f'<robot name="r">{LINK}<loop_joint name="l"/>\n{leg(more=more)}</robot>'
    with pytest.warns(rr.UrdfWarning) as caught:
        robot = read(text)
    assert len(caught) == 1
    message = str(caught[0].message)
    for part in (
        "<loop_joint> (line 1)",
        "K of joint hip (line 2)",
        "the second <axis> of joint hip",
    ):
        assert part in message
    assert robot.joints.damping.tolist() == [1.0]


# Inertias


@pytest.mark.parametrize(
    ("diagonal", "says"),
    [
        (
            (0.001, 0.001, 0.01),
            r"A \+ B < C, which no body has, in kg m\^2: b \(0.001, 0.001, 0.01\)",
        ),
        (
            (6.4, 5.3, 3.1),
            r"gyration far beyond .*: b \(2.53 m\), so that it rocks with a period of",
        ),
        ((0.0064, 0.0053, 0.0031), None),
        ((0.0, 0.0, 0.0), None),
        ((0.002, 0.002, 0.004), None),
        ((0.002, 0.002, 0.004019), None),
    ],
)
def test_impossible_inertias(diagonal, says):
    xx, yy, zz = diagonal
    text = (
        '<robot name="r"><link name="b"><inertial><origin xyz="0 0 -0.05"/><mass value="1"/>'
        f'<inertia ixx="{xx}" ixy="0" ixz="0" iyy="{yy}" iyz="0" izz="{zz}"/></inertial></link>'
        "</robot>"
    )
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        robot = rr.Robot.from_urdf(text, shell=rr.Sphere(0.12))
    if says is None:
        assert not caught
        return
    assert len(caught) == 1
    with pytest.warns(rr.UrdfWarning, match=says):
        rr.Robot.from_urdf(text, shell=rr.Sphere(0.12))
    if "period" in says:
        told = float(str(caught[0].message).split("period of ")[1].split(" s")[0])
        assert told == pytest.approx(
            rr.orbits.modes(rr.FullModel(robot, damping=None), ())[0].period, rel=0.1
        )


def test_all_links_are_in_one_warning():
    rng = np.random.default_rng(0)
    parts = [link("body", 1.0, rng)]
    for i in range(5):
        thin = link(f"l{i}_link", 0.1, rng)
        head, tail = thin.split("izz=")
        parts += [
            f'{head}izz="0.1"{tail.split(chr(34), 2)[2]}',
            joint(f"l{i}", "body", "revolute", rng),
        ]
    with pytest.warns(rr.UrdfWarning) as caught:
        read(f'<robot name="r">{"".join(parts)}</robot>')
    assert len(caught) == 1
    assert all(f"l{i}_link" in str(caught[0].message) for i in range(5))
