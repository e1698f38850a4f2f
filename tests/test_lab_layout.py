"""Nothing of the laboratory's picture is behind its panel."""

import math

import numpy as np
import pytest

import rrrobot as rr
from rrrobot.lab.layout import framing
from rrrobot.view.commands import FIELD_OF_VIEW
from rrrobot.view.scene import Scene

SCENE = Scene(rr.Robot.from_parameters())
TURN = np.linspace(0.0, 1.2, 40)
ARC = np.column_stack((0.5 * np.sin(TURN), 0.5 * (1 - np.cos(TURN)), 0 * TURN + SCENE.size))
LINE = np.column_stack((4.0 * TURN, 0 * TURN, 0 * TURN + SCENE.size))


def seen(points, at, size):
    """Where points (n, 3) are in a picture, both coordinates from -1 to 1 (n, 2)."""
    toward = (at.position - at.look_at) / np.linalg.norm(at.position - at.look_at)
    right = np.cross((0.0, 0.0, 1.0), toward)
    right /= np.linalg.norm(right)
    arm = points - at.position
    depth = -(arm @ toward) * math.tan(math.radians(FIELD_OF_VIEW / 2))
    return np.column_stack(
        (arm @ right / depth * size[1] / size[0], arm @ np.cross(toward, right) / depth)
    )


@pytest.mark.parametrize("centers", (ARC, LINE, ARC[:1]), ids=("arc", "line", "place"))
@pytest.mark.parametrize(
    "size, bottom", (((390, 844), -0.04), ((736, 700), -1.0), ((896, 720), -1.0))
)
def test_robot_and_path_are_in_the_part_of_the_picture_that_is_free(size, bottom, centers):
    at = framing(SCENE.view(centers), np.array((0.0, 0.0, 1.0)), size)
    steps = SCENE.reach * np.vstack((np.eye(3), -np.eye(3)))
    found = seen((centers[:, None] + steps).reshape(-1, 3), at, size)
    assert np.abs(found[:, 0]).max() <= 1.0
    assert found[:, 1].min() >= bottom and found[:, 1].max() <= 1.0
    # Nor is it lost in the picture: across or upwards it takes a good part of what is free.
    wide, high = np.ptp(found, axis=0) / (2.0, 1.0 - bottom)
    assert max(wide, high) > 0.5
