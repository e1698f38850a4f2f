"""Off a rock: a board with a heavy arm that leans over the belly's edge."""

import json
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pinocchio as pin
import pytest

import rrrobot as rr
from rrrobot.belly.clearance import clearances
from rrrobot.belly.swings import leaning
from rrrobot.escape.edges import EDGE, edge_radius
from rrrobot.escape.goals import goal_of
from rrrobot.escape.landing import goes_over, heights
from rrrobot.escape.limits import EscapeLimits
from rrrobot.escape.report import report_html
from rrrobot.escape.rolling_off import (
    _attempt,
    _moves,
    _rises,
    _search,
    lacks,
    lean,
    roll_off,
)
from rrrobot.escape.spaces import GROUPS
from rrrobot.escape.story import _Work
from rrrobot.escape.unstuck import Unstuck
from rrrobot.escape.way_rows import off_rows
from rrrobot.escape.ways import way_of
from rrrobot.robot.joints import JointIndex
from rrrobot.robot.legged import legged_urdf
from tests.pages import are_printed, numbers
from tests.test_belly import BALL, HEIGHT, LENGTH, MASS, WIDTH, joint, link

ARM, RADIUS = 2.0, 0.25
LIMITS = EscapeLimits(friction=0.6)


def crane_of(reach):
    x, y, z = (MASS / 12 * np.array((LENGTH, WIDTH, HEIGHT)) ** 2).tolist()
    base = link("base", MASS, (y + z, x + z, x + y), f'<box size="{LENGTH} {WIDTH} {HEIGHT}"/>')
    arm = link("arm", ARM, (1e-3,) * 3, f'<sphere radius="{BALL}"/>', (0, 0, reach))
    hip = joint("hip", "arm", (0, 0, HEIGHT / 2 + 0.05), axis="1 0 0", limits=(-1.0, 1.0))
    robot = rr.Robot.from_urdf(f'<robot name="crane">{base}{arm}{hip}</robot>',
                               shell=rr.Sphere(1.0))  # fmt: skip
    return rr.fit_belly(robot, ground=rr.Boulder(RADIUS), posture=(0.0,))


@pytest.fixture(scope="module")
def crane():
    return crane_of(0.15)


def off(belly, goal, **options):
    ends = LIMITS.ends(belly.robot)._replace(velocity=np.array((3.0,)))
    return roll_off(belly, goal_of(goal), LIMITS, ends, damping=0.3, **{"floor": 1.0, **options})


def leans(belly, limits, floor=1.0):
    """What comes of leaning to the left alone."""
    rate, side = np.full(belly.robot.n_legs, 3.0), np.array((0.0, 1.0))
    search = _search(belly, np.pi / 2, floor)
    passed = leaning(search, belly.posture, side, max(_rises(search)))
    model = rr.FullModel(belly.robot, ground=belly.ground, damping=0.3)
    return _attempt(belly, goal_of("off:90"), limits, model, floor, (0.0, 0.0),
                    _moves(passed, limits.use * rate, 0.5))  # fmt: skip


def test_a_robot_leans_over_the_edge_and_slides_off_to_that_side(crane):
    way = off(crane, "off:90")
    assert way.met and way.ended == "slide" and way.reason == ""
    # The arm goes to the end of its range, less what is kept there.
    most = ARM * 0.15 / (ARM + MASS) * np.sin(1.0)
    assert 0.9 * most < way.shift < most
    run = way.trajectory
    assert 0 < way.over < way.duration and way.friction <= LIMITS.friction
    # Over the edge it goes on without a jump of place, velocity or leg.
    assert np.diff(run.time).min() > 0 and run.slip.max() < 1e-9
    at = int(np.searchsorted(run.time, way.over))
    jump = run.velocity[at + 1] - run.velocity[at]
    assert np.abs(jump).max() < 0.2 and np.abs(np.diff(run.configuration, axis=0)).max() < 0.1
    # It falls to the left, where it needs just the friction that there is.
    assert np.rad2deg(run.euler[-1, 0]) < -20 and run.position[-1, 1] > 0.05
    needed = run.required_friction
    assert needed[at + 1 :].max() <= LIMITS.friction * (1 + 1e-6)
    assert needed[-1] == pytest.approx(LIMITS.friction, rel=1e-2)
    side = np.array((0.0, 1.0))
    assert goes_over(crane, run, side) and not goes_over(crane, run, -side)
    # It is left of the rock, leans left, and could fall no faster than its energy allows.
    at, last = way.landing, run.configuration[-1]
    assert (at.ahead, at.left) == tuple(last[:2]) and at.left > 0.05 and abs(at.heading) < 0.1
    assert at.tilt == pytest.approx(-run.euler[-1, 0], abs=0.05)
    model = run.robot.model
    center = [np.array(pin.centerOfMass(model, model.createData(), q)) for q in
              run.configuration[-2:]]  # fmt: skip
    speed = np.linalg.norm(center[1] - center[0]) / (run.time[-1] - run.time[-2])
    assert at.speed == pytest.approx(speed, rel=0.1) and at.speed > 0.05
    assert 0 < at.room < 1.0 and at.impact**2 == pytest.approx(at.speed**2 + 2 * 9.81 * at.room)
    rows = off_rows(way)
    assert "mm left of the rock's top" in rows["there its base is"]
    assert rows["leaning, at the belly's edge"] == f"{1000 * way.short:.0f} mm short of going over"
    assert "comes down at up to" in rows["to the floor it still falls"]


def test_what_does_not_go_off_says_why(crane):
    way = off(crane, "off:0")
    assert "0 mm to that side" in way.reason and lacks(way.short, way.least) in way.reason
    # At the edge ahead the board leans by its half length over the radius.
    half, mass = crane.shell.half_length, ARM + MASS
    assert half == pytest.approx(LENGTH / 2, rel=0.01)
    high = (MASS * HEIGHT / 2 + ARM * (HEIGHT + 0.05 + 0.15)) / mass
    lacking = half * np.cos(half / RADIUS) - high * np.sin(half / RADIUS)
    assert way.short == pytest.approx(lacking, abs=1e-6) and way.least == pytest.approx(lacking)
    assert f"{1000 * lacking:.0f} mm short of going over" in way.reason
    with pytest.raises(rr.ParameterError, match=r"floor is -0\.1 m"):
        off(crane, "off:90", floor=-0.1)
    level = rr.fit_belly(crane.robot, posture=(0.0,))
    with pytest.raises(rr.ModelError, match="off:90 needs a rock: the ground is Plane"):
        off(level, "off:90")


def test_an_edge_is_as_wide_as_the_base_beyond_it(crane):
    place, outward = np.array((0.0, WIDTH / 2, -HEIGHT / 2)), np.array((0.0, 1.0, 0.0))
    assert edge_radius(crane, place, outward) == EDGE
    (board,) = crane.shapes.on_joint(1)
    wider = board._replace(points=np.vstack((board.points, place + np.array((0.1, 0.03, 0.02)))))
    pieces = [wider if piece is board else piece for piece in crane.shapes.pieces]
    belly = replace(crane, shapes=replace(crane.shapes, pieces=pieces))
    radius = edge_radius(belly, place, outward)
    angles = np.deg2rad((15.0, 30.0, 45.0))
    beyond = 0.03 * np.sin(angles) - 0.02 * np.cos(angles)
    left = radius * (1 - np.cos(angles)) - beyond
    assert radius > EDGE and left.min() == pytest.approx(0, abs=1e-12)


def test_the_rock_holds_a_robot_whose_legs_reach_less_far():
    belly = crane_of(0.1)
    way = leans(belly, LIMITS)
    assert not way.met and "it stays on the rock" in way.reason and np.isnan(way.over)
    # c R / (R - h), in an arc: the centre of mass comes to stand over the contact.
    run, turn = way.trajectory, float(way.drive(9.0).angle[0])
    height = (MASS * HEIGHT / 2 + ARM * (HEIGHT + 0.05 + 0.1 * np.cos(turn))) / (ARM + MASS)
    tilt = np.arcsin(run.position[-1, 1] / RADIUS)
    lever = way.shift * np.cos(tilt) + height * np.sin(tilt)
    place = RADIUS * tilt
    assert lever == pytest.approx(place * np.cos(tilt), abs=1e-3)


def test_a_belly_that_rocks_to_its_edge_and_back_goes_on_on_its_face():
    """About its edge it may only turn outward: inward the flat face is in the way."""
    belly = crane_of(0.12)
    way = leans(belly, EscapeLimits(friction=2.0))
    assert not way.met and "it stays on the rock" in way.reason and np.isnan(way.over)
    run = way.trajectory
    # To the edge, beyond it and back: no jump of pose, velocity or leg on the way.
    turns = np.array([pin.Quaternion(q[3:7]).toRotationMatrix() for q in run.configuration])
    tilt = np.arcsin(-turns[:, 2, 1])
    assert np.abs(tilt).max() > 1.02 * WIDTH / 2 / RADIUS and abs(tilt[-1]) < WIDTH / 2 / RADIUS
    assert np.diff(run.time).min() > 0 and run.slip.max() < 1e-9
    assert np.abs(np.diff(run.configuration, axis=0)).max() < 0.05
    assert np.abs(np.diff(run.velocity, axis=0)).max() < 0.3
    found = clearances(belly.shapes, run.configuration, belly.ground)
    # The edge of the model is inside the box's by up to its radius.
    assert found.ground[:, found.links.index("base")].min() > -2e-3


@pytest.fixture(scope="module")
def quadruped():
    return rr.fit_belly(legged_urdf(4), ground=rr.Boulder(0.3), floor=0.3)


@pytest.mark.parametrize("azimuth", [pytest.param(0.0, marks=pytest.mark.slow), np.pi / 2])
def test_legs_lean_on_ways_that_touch_nothing(quadruped, azimuth):
    """Capsules and postures in between choose the way; Coal judges the links' own shapes."""
    belly, side = quadruped, np.array((np.cos(azimuth), np.sin(azimuth)))
    search = _search(belly, azimuth, 0.3)
    passed = leaning(search, belly.posture, side, max(_rises(search)))
    model, index = belly.robot.model, JointIndex(belly.robot.model, belly.robot.legs)
    way = np.vstack([a + np.linspace(0, 1, 25)[:, None] * (b - a) for a, b in pairwise(passed)])
    rest = belly.model()
    q = np.tile(rest.configuration(rest.make_pose(belly.rest, np.zeros(2)), way[0]), (len(way), 1))
    for row, angle in zip(q, way, strict=True):
        index.write(row, angle)
    found = clearances(belly.shapes, q, belly.ground)
    limbs = [i for i, name in enumerate(found.links) if name not in {"body", *belly.covered}]
    assert found.ground[:, limbs].min() > 0 and found.between.min() > 0.001
    assert min(heights(belly, row).min() for row in q) > -0.3
    centers = np.array([pin.centerOfMass(model, model.createData(), row)[:2] for row in q]) @ side
    assert centers[-1] - centers[0] > 0.01 and centers.min() > centers[0] - 0.005


def test_limbs_of_a_posture_on_a_rock_keep_off_the_floor():
    def lowest(floor):
        belly = rr.fit_belly(legged_urdf(2), ground=rr.Boulder(0.3), floor=floor)
        model = belly.model()
        pose = model.make_pose(belly.rest, np.zeros(2))
        return heights(belly, model.configuration(pose, belly.posture)).min()

    assert lowest(None) < -0.1 and lowest(0.09) > -0.09


def test_the_story_goes_on_until_it_lies_on_the_floor(tmp_path):
    def told():
        return rr.unstick(
            crane_of(0.15), goals=["off:90"], floor=1.0, budget=300, postures=1, limits=LIMITS,
            folder=tmp_path,
        )  # fmt: skip

    found = told()
    way = found.off["off:90"]
    (lying,) = way.lying
    assert found.met and way.met and way.after is None
    # On the arm's side, with the board's edge: no belly.
    assert (
        lying.links == ("arm", "base")
        and lying.tilt > np.pi / 2
        and lying.left > way.path[0][-1, 1]
    )
    np.testing.assert_allclose(way.path[1][0], way.path[0][-1])
    rows = off_rows(way)
    assert "arm, base" in rows["comes to lie on"] and "on its side" in rows["comes to lie on"]
    assert "takes all of its energy" in rows["assumed of that"]
    assert rows["goes on from there"] == "no: it does not lie on its belly"
    page = report_html(found, films=False)
    assert "comes to lie on" in page and page.count("data:image/png") == 2
    # What is on disk says the same.
    assert told().off["off:90"].to_dict() == way.to_dict()


def test_a_foot_that_reaches_the_floor_first_is_no_way_off():
    belly = rr.fit_belly(legged_urdf(2), ground=rr.Boulder(0.3))
    way = leans(belly, LIMITS, 0.112)
    assert way.ended == "floor" and way.link.endswith("shank") and not way.met
    assert f"{way.link} reaches the floor while the belly still lies on the rock" in way.reason


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::rrrobot.UrdfWarning")
def test_a_real_robot_goes_from_its_rock_to_a_gait_on_the_floor():
    """ANYmal slides off, tips onto its thighs, and its legs let it down on its belly."""
    found = rr.unstick("anymal", ground=rr.Boulder(0.4), goals=["off:90"], budget=600, postures=1)
    way = found.off["off:90"]
    assert found.met and way.ended == "slide" and len(way.lying) == 1
    (lying,) = way.lying
    assert lying.links == ("base",) and lying.tilt < 1e-3 and "base" not in lying.first
    assert len(lying.postures) == 3 and way.stays == ""
    gait = way.after
    assert gait.met and gait.value > 0.05
    assert way.path[-1][-1, 1] > 0.5
    # It turns as it gets going; the gait is chosen by where it leads, and the report says so.
    astray = np.rad2deg(way.astray)
    assert 0 < astray < 20
    assert f"{astray:.0f} deg to the left of that side" in off_rows(way)["goes on from there"]
    assert "by way of 2" in off_rows(way)["assumed of that"]
    assert lying.first == ("LF_THIGH", "LH_THIGH", "RF_THIGH", "RH_THIGH")
    half = found.belly.shell.half_width
    for value, page, sentence in (
        (way.over, "tutorials/ten_lines.md", r"belly's edge after ([\d.]+) s"),
        (1000 * gait.value, "tutorials/ten_lines.md", r"the gait goes at (\d+) mm/s"),
        (astray, "tutorials/ten_lines.md", r"(\d+) degrees to the left of that side"),
        (way.duration, "tutorials/ten_lines.md", r"slides off by ([\d.]+) s"),
        (way.landing.room, "tutorials/ten_lines.md", r"falls ([\d.]+) m onto its four thighs"),
        (1000 * half, "tutorials/ten_lines.md", r"narrow, half of it (\d+) mm"),
        (
            1000 * way.shift,
            "tutorials/ten_lines.md",
            r"heavy: they move the centre of mass by (\d+) mm",
        ),
    ):
        are_printed([value], page, sentence)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::rrrobot.UrdfWarning")
@pytest.mark.parametrize(("name", "page", "sentence"), [
    ("anymal_c", "tutorials/ten_lines.md", r"\| ANYmal C \| (\d+) mm \| (\S+) mm \| (\S+) mm"),
    ("anymal", "tutorials/ten_lines.md", r"\| ANYmal B \| (\d+) mm \| (\S+) mm \| (\S+) mm"),
    ("solo12", "tutorials/ten_lines.md", r"\| Solo12 \| (\d+) mm \| (\S+) mm \| (\S+) mm"),
    ("go1", "tutorials/ten_lines.md", r"\| Go1 \| (\d+) mm \| (\S+) mm \| (\S+) mm"),
    ("laikago", "tutorials/ten_lines.md", r"\| Laikago \| (\d+) mm \| (\S+) mm \| (\S+) mm"),
    ("a1", "tutorials/ten_lines.md", r"\| A1 \| (\d+) mm \| (\S+) mm \| (\S+) mm"),
])  # fmt: skip
def test_how_far_legs_are_from_taking_a_robot_off_its_rock(name, page, sentence):
    belly = rr.fit_belly(name, ground=rr.Boulder(0.4), floor=0.4)
    ways, least = lean(belly, np.array((0.0, 1.0)), 0.4)
    found = belly.shell.half_width, min(short for _, short in ways), least
    assert tuple(round(1000 * one) for one in found) == numbers(page, sentence)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::rrrobot.UrdfWarning")
@pytest.mark.parametrize(("name", "ends"), [("solo12", ""), ("anymal_c", "LF_FOOT")])
def test_what_becomes_of_two_robots_on_a_rock(name, ends):
    belly = rr.fit_belly(name, ground=rr.Boulder(0.4), floor=0.4)
    way = _Work(belly, EscapeLimits(), None, GROUPS, None, 0.1, 1).off(goal_of("off:90"), None)
    assert way.link == ends and way.met == bool(ends) == (way.short < 0)
    assert way.met or lacks(way.short, way.least) in way.reason


@pytest.mark.slow
def test_a_robot_that_comes_down_on_its_belly_goes_on_to_that_side(tmp_path):
    """A ball that its rock lets go upright: the fall is made up, what follows is not."""
    belly = rr.fit_belly(rr.Robot.from_parameters(), ground=rr.Boulder(1.0))
    work = _Work(belly, EscapeLimits(), None, GROUPS, None, 0.1, 1)
    # It faces ahead as it falls; the side that is wanted is the left.
    way = replace(work.off(goal_of("off:0"), 0.3), goal=goal_of("off:90"), met=True,
                  ended="lift-off", reason="", link="")  # fmt: skip
    way = work.onward(way, 600, 1, 1, lambda *_: None)
    (lying,) = way.lying
    gait = way.after
    assert way.stays == "" and lying.links == ("shell",) and gait.met
    # In one frame: it goes on from where it lies, to the wanted side.
    falls, goes = way.path[1:]
    np.testing.assert_allclose(goes[0], falls[-1])
    period, run = gait.gait.period, gait.trajectory
    cycle = int(np.searchsorted(run.time, run.time[-1] - 4 * period - 1e-9))
    velocity = (goes[-1] - goes[cycle]) / (run.time[-1] - run.time[cycle])
    assert velocity @ way.goal.weights[:2] == pytest.approx(gait.value, rel=0.02)
    wanted = np.arctan2(way.goal.weights[1], way.goal.weights[0])
    found = np.arctan2(*velocity[::-1])
    assert found == pytest.approx(wanted, abs=np.deg2rad(10))
    assert way.astray == pytest.approx(found - wanted, abs=1e-6)
    assert "of that side" in off_rows(way)["goes on from there"]
    found = replace(Unstuck.begun(belly, EscapeLimits(), [way.goal], None), off={"off:90": way})
    names = {path.name for path in found.save(tmp_path)}
    page = (tmp_path / "report.html").read_text()
    assert 'href="off_90_floor.html"' in page and "Settled cycle on the floor" in page
    assert {"off_90.html", "off_90_floor.html", "off_90_floor.json"} <= names
    way.trajectory.save(tmp_path / "run.npz")
    gait.trajectory.save(tmp_path / f"{way.after_name}.npz")
    again = way_of(way.to_dict(), tmp_path, "run.npz")
    assert json.dumps(again.to_dict()) == json.dumps(way.to_dict())
