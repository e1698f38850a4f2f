"""Films of machines: every link is drawn, where the machine's own model has it."""

import numpy as np
import pinocchio as pin
import pytest
from click.testing import CliRunner

import rrrobot as rr
from rrrobot.cli.main import cli
from rrrobot.view.player import play_of
from rrrobot.view.shapes import robot_visuals


def moved(name):
    body = rr.machines.by_name(name)
    gait = next(iter(body.gaits.values()), None)
    return body.simulate(gait, 0.2, sample_interval=0.1, method="kkt")


@pytest.mark.parametrize("name", rr.machines.all_names())
def test_all_that_weighs_is_drawn_where_it_is(name):
    t = moved(name)
    play = play_of(t)
    drawn, own = play.robot.model, t.model.model
    data, theirs = drawn.createData(), own.createData()
    height = play.configuration[0, 2] - (0.0 if t.model.planar else t.pose[0, 2])
    for q, state in zip(play.configuration, t.states, strict=True):
        pin.framesForwardKinematics(drawn, data, q)
        z, _ = t.model.split(state)
        pin.framesForwardKinematics(own, theirs, t.model.coordinates.to_q(z))
        for joint in t.tree.joints:
            link = joint.child.name
            found, wanted = (d.oMf[m.getFrameId(link)] for d, m in ((data, drawn), (theirs, own)))
            np.testing.assert_allclose(found.rotation, wanted.rotation, atol=1e-12)
            np.testing.assert_allclose(
                found.translation - (0, 0, height), wanted.translation, atol=1e-12
            )
    seen = {visual.name for visual in robot_visuals(play.robot)}
    heavy = {joint.child.name for joint in t.tree.joints if np.any(joint.child.about_centre)}
    assert heavy <= seen and seen & {t.tree.base.name, "shell"}


def test_contacts_of_a_film_stand_still_on_the_shell():
    # The path is the contact's: rolling, its speed is that of the shell's centre on a plane.
    ball = rr.machines.chaplygin_sphere()
    play = play_of(ball.simulate(None, 0.5, sample_interval=0.1))
    np.testing.assert_allclose(play.position, play.configuration[:, :2], atol=1e-12)
    stone = rr.machines.rattleback()
    tilted = stone.at(rr.rotations.quaternion_from_euler((0.0, 0.02, 0.0)))
    play = play_of(stone.simulate(None, 0.1, pose=tilted, sample_interval=0.05))
    assert np.abs(play.position - play.configuration[:, :2]).max() > 1e-3


def test_the_command_writes_a_film(tmp_path):
    words = ["machines", "sphericle", "--duration", "0.2", "--film"]
    done = CliRunner().invoke(cli, [*words, str(tmp_path / "ball.html")])
    assert done.exit_code == 0, done.output
    assert b"meshcat" in (tmp_path / "ball.html").read_bytes().lower()
    done = CliRunner().invoke(cli, [*words, str(tmp_path / "ball.txt")])
    assert done.exit_code != 0 and "ends in .htm" in done.output
