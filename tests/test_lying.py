"""How a robot comes to lie on a floor: boxes that tip as geometry says, falls as mechanics says."""

import numpy as np
import pinocchio as pin
import pytest
from scipy.optimize import nnls

import rrrobot as rr
from rrrobot.escape.lying import Pose, comes_to_lie, fallen, held, nearest, tipped
from tests.test_belly import HEIGHT, WIDTH, board
from tests.test_rolling_off import crane_of

NO_LEGS = np.zeros(0)
FLOOR = -0.7


@pytest.fixture(scope="module")
def box():
    robot = rr.Robot.from_urdf(board(arms=False), shell=rr.Sphere(1.0))
    return rr.belly.Shapes.of(robot)


def posed(roll, place=(0.0, 0.0, 0.0), leg=()):
    turn = pin.Quaternion(pin.exp3(np.array((roll, 0.0, 0.0))))
    return np.concatenate((place, turn.coeffs(), leg))


@pytest.mark.parametrize(("share", "ends"), [(0.97, 0.0), (1.03, np.pi / 2)])
def test_a_box_tips_to_the_side_that_its_diagonal_says(box, share, ends):
    """Above the edge's balance, tan(roll) = width / height, it goes over to its side."""
    roll = share * np.arctan2(WIDTH, HEIGHT)
    (way,) = comes_to_lie(box, posed(roll), np.zeros(6), FLOOR, [NO_LEGS], 9.81)
    assert way.tilt == pytest.approx(ends, abs=1e-7) and way.links == ("base",)
    # The edge on which it came down stays; the middle is half a side from it.
    edge = -WIDTH / 2 * np.cos(roll) + HEIGHT / 2 * np.sin(roll)
    middle = edge + (WIDTH / 2 if ends == 0 else -HEIGHT / 2)
    assert (way.ahead, way.left) == pytest.approx((0.0, middle), abs=1e-9)


def test_it_falls_as_a_free_body_does(box):
    body, gravity = held(box, NO_LEGS), 9.81
    spin = body.inertia @ np.array((0.0, 7.0, 0.0))
    begun = Pose(np.eye(3), np.zeros(3))
    end = fallen(body, begun, spin, np.array((0.3, -0.2, 0.5)), FLOOR, gravity)
    assert end.of(body.points)[:, 2].min() == pytest.approx(FLOOR, abs=5e-3)
    time = (0.5 + np.sqrt(0.25 - 2 * gravity * end.place[2])) / gravity
    np.testing.assert_allclose(end.place[:2], time * np.array((0.3, -0.2)), rtol=1e-9)
    np.testing.assert_allclose(pin.log3(end.turn), (0.0, 7.0 * time, 0.0), atol=1e-9)
    # About no principal axis it tumbles, and keeps its energy.
    spin = body.inertia @ np.array((3.0, 5.0, 4.0))
    end = fallen(body, begun, spin, np.zeros(3), FLOOR, gravity)
    energies = [(a := turn.T @ spin) @ np.linalg.solve(body.inertia, a)
                for turn in (begun.turn, end.turn)]  # fmt: skip
    assert energies[1] == pytest.approx(energies[0], rel=1e-6)
    assert abs(end.turn - np.eye(3)).max() > 0.5


def test_a_robot_tips_downhill_until_it_stands():
    belly = crane_of(0.15)
    rng = np.random.default_rng(2)
    for _ in range(20):
        body = held(belly.shapes, rng.uniform(-1.0, 1.0, 1))
        pose = Pose(pin.exp3(rng.normal(size=3) * 1.5), np.zeros(3))
        poses, links = tipped(body, pose, FLOOR)
        heights = [(one.turn @ body.center + one.place)[2] for one in poses]
        assert np.all(np.diff(heights) < 0) and set(links) <= {"base", "arm"}
        points = poses[-1].of(body.points)
        assert points[:, 2].min() == pytest.approx(FLOOR, abs=1e-9)
        # It stands: its centre of mass is over what is on the floor.
        on = points[points[:, 2] < FLOOR + 1e-6]
        center = poses[-1].turn @ body.center + poses[-1].place
        rows = np.vstack((on[:, :2].T, np.ones(len(on))))
        assert nnls(rows, np.append(center[:2], 1.0))[1] < 1e-5


def test_the_nearest_place_of_a_hull():
    square = np.array(((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)))
    for at, found in (((0.3, 0.6), (0.3, 0.6)), ((0.4, -2.0), (0.4, 0.0)), ((3.0, 3.0), (1, 1))):
        np.testing.assert_allclose(nearest(square, np.array(at)), found, atol=1e-12)
    np.testing.assert_allclose(nearest(square[:1], np.array((2.0, 1.0))), (0, 0))


def test_where_turning_decides_both_ways_are_told(box):
    time = np.sqrt(2 * (-FLOOR - 0.1) / 9.81)
    rate = np.array((0.5 * np.pi / time, 0.0, 0.0))
    ways = comes_to_lie(box, posed(0.0), np.append(np.zeros(3), rate), FLOOR, [NO_LEGS], 9.81)
    assert [way.tilt for way in ways] == pytest.approx((np.pi / 2, 0.0), abs=1e-7)
    slow = np.append(np.zeros(3), 0.2 * rate)
    assert len(comes_to_lie(box, posed(0.0), slow, FLOOR, [NO_LEGS], 9.81)) == 1


def test_the_legs_go_to_their_posture_and_it_tips_on():
    """A crane that stands on its board, its arm far out at the side, falls over it."""
    shapes = crane_of(0.6).shapes
    (way,) = comes_to_lie(shapes, posed(0.0, leg=(0.0,)), np.zeros(7), FLOOR, [np.ones(1)], 9.81)
    assert way.first == ("base",) and way.links == ("arm", "base")
    # About its right edge.
    y, z = np.cos(way.tilt), np.sin(way.tilt)
    assert way.tilt > 0.3
    assert way.left == pytest.approx(-WIDTH / 2 + WIDTH / 2 * y - HEIGHT / 2 * z, abs=1e-9)
