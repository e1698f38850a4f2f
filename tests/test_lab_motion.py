"""The laboratory's motions and maps, without a page."""

import socket
import sys
from dataclasses import replace

import numpy as np
import pytest

import rrrobot as rr
from rrrobot.lab.ghosts import ghost
from rrrobot.lab.knobs import Knobs
from rrrobot.lab.maps import inverse, motion_map, placed
from rrrobot.lab.motion import Screw
from rrrobot.lab.outcome import Refusal, settle
from rrrobot.lab.stage import triangles
from rrrobot.view.commands import mesh

ROBOT = rr.Robot.from_parameters()
KNOBS = Knobs.of(ROBOT)


@pytest.fixture(scope="module")
def circular():
    return settle(ROBOT, KNOBS)


def test_the_path_is_that_of_a_simulation(circular):
    # The general form, by the KKT system, from the cycle's start: nothing of the page's engine.
    cycle, periods = circular.cycle, 5
    t = rr.simulate(
        rr.FullModel(ROBOT), rr.gait("circular"), periods * cycle.period, cycle.period / 36,
        euler=cycle.euler, start=cycle.euler_rates,
    )  # fmt: skip
    path = circular.path()[: len(t)]
    assert np.abs(path - t.position).max() < 1e-8
    assert circular.friction == pytest.approx(t.required_friction.max(), rel=1e-6)
    assert circular.torque == pytest.approx(np.abs(t.leg_torque).max(), rel=1e-6)
    assert circular.normal_force == pytest.approx(t.normal_force.min(), rel=1e-4)


def test_the_numbers_are_those_of_a_long_run(circular):
    state = rr.simulate(
        rr.FullModel(ROBOT), rr.gait("circular"), duration=30.0, method="momentum"
    ).steady_state()
    assert circular.speed == pytest.approx(state.speed, rel=1e-5)
    assert circular.yaw_rate == pytest.approx(state.yaw_rate, rel=1e-5)


def test_what_a_knob_changes_is_what_a_simulation_of_it_changes(circular):
    # Masses, radius, gravity, losses and the second harmonic at once.
    knobs = replace(
        KNOBS, body=(0.06, 0.05, 0.3, 0.09, 0.13), gravity=5.0, damping=0.02, frequency=6.0,
        damping_kind="body", overtone=((0.1, 0.0), (0.0, 0.05)),
        overtone_phase=((0.4, 0.0), (0.0, 1.0)),
    )  # fmt: skip
    found = settle(ROBOT, knobs, circular)
    p = rr.RRRobotParameters(
        leg_mass=0.06, servo_mass=0.05, battery_mass=0.3, leg_length=0.09, shell_radius=0.13,
        hip_offset=0.13, gravity=5.0,
    )  # fmt: skip
    model = rr.FullModel(rr.Robot.from_parameters(p), damping=rr.BodyRateDamping(0.02, 0.02, 0.02))

    def legs(t):
        first = np.pi / 4 + 0.3 * np.sin(6 * t) + 0.1 * np.sin(12 * t + 0.4)
        second = np.pi / 4 + 0.3 * np.cos(6 * t) + 0.05 * np.sin(18 * t + 1.0)
        return np.stack((first, second), axis=-1)

    times = np.linspace(0.0, np.pi / 3, 50)
    assert knobs.gait()(times).angle == pytest.approx(legs(times), abs=1e-12)
    state = rr.simulate(model, knobs.gait(), 40.0, method="momentum").steady_state()
    assert found.speed == pytest.approx(state.speed, rel=1e-4)
    assert found.yaw_rate == pytest.approx(state.yaw_rate, rel=1e-4)


def test_playing_goes_along_the_path(circular):
    scene_points = []
    for k in (0, 1, 17, 40):
        time = k * circular.period + 5 * circular.period / 36
        q, shift, at = circular.frame(time)
        assert at == pytest.approx(5.0, abs=1e-9)
        own = circular.trajectory.configuration[5]
        assert q == pytest.approx(own, abs=1e-9)
        scene_points.append(shift.act(np.array((*circular.trajectory.position[5], 0.0)))[:2])
    along = circular.path()[[5, 36 + 5, 17 * 36 + 5, 40 * 36 + 5]]
    assert np.array(scene_points) == pytest.approx(along, abs=1e-12)


def test_powers_of_a_screw_are_its_repetitions():
    screw = Screw(0.3, np.array((0.02, -0.01)))
    at, turned = np.zeros(2), 0.0
    for _ in range(9):
        c, s = np.cos(turned), np.sin(turned)
        at = at + np.array(((c, -s), (s, c))) @ screw.displacement
        turned += screw.turn
    turns, moved = screw.power(9)
    assert turns[0] == pytest.approx(turned) and moved[0] == pytest.approx(at, abs=1e-15)
    straight = Screw(0.0, screw.displacement).power(9)[1][0]
    assert straight == pytest.approx(9 * screw.displacement)


def test_knobs_that_have_no_motion_say_so():
    with pytest.raises(Refusal, match="lifts off"):
        settle(ROBOT, replace(KNOBS, frequency=20.0, amplitude=(1.2, 1.2)))
    with pytest.raises(Refusal, match="No settled motion"):
        settle(ROBOT, replace(
            KNOBS, offset=(0.785, 1.878), amplitude=(1.135, 1.264), frequency=3.44, gravity=22.5,
            body=(0.1387, *KNOBS.body[1:]),
        ))  # fmt: skip
    with pytest.raises(Refusal, match="leg_length"):
        settle(ROBOT, replace(KNOBS, body=(*KNOBS.body[:3], -1.0, KNOBS.body[4])))


def test_without_losses_nothing_settles_and_it_is_said():
    found = settle(ROBOT, replace(KNOBS, damping=0.0, horizon=10.0))
    assert not found.settled and found.screw is None
    assert any("Not settled" in word for word in found.words)


def test_a_link_holds_everything_and_only_that():
    knobs = replace(KNOBS, offset=(0.1, 0.2), slope=0.05, overtone=((0.1, 0.0), (0.0, 0.0)))
    assert KNOBS.read(knobs.text()) == knobs
    other = Knobs.of(
        rr.Robot.from_urdf(rr.urdf_path("rrrobot"), shell=rr.Sphere(0.12), legs=("leg_1",))
    )
    for bad in ("", "!!", knobs.text()[:-5], other.text(), "A" * 200):
        with pytest.raises(rr.ParameterError, match="link"):
            KNOBS.read(bad)
    # NaN and zero periods never come in.
    for wrong in (replace(knobs, damping=float("nan")), replace(knobs, frequency=0.0)):
        with pytest.raises(rr.ParameterError):
            KNOBS.read(wrong.text())


def test_the_map_shows_the_motions_that_the_gaits_have():
    chart = motion_map(ROBOT, KNOBS)
    for i, j in ((23, 27), (4, 11)):
        there = settle(ROBOT, placed(KNOBS, chart.offset[i], chart.phase[j]))
        assert chart.speed[i, j] == pytest.approx(there.speed, rel=1e-5)
        assert chart.yaw_rate[i, j] == pytest.approx(there.yaw_rate, abs=1e-6)
    knobs = inverse(ROBOT, KNOBS, chart, 0.004, 2.5)
    found = settle(ROBOT, knobs)
    assert found.speed == pytest.approx(0.004, rel=1e-5)
    assert found.curvature == pytest.approx(2.5, rel=1e-5)
    # Out of reach: the nearest, not an error.
    fast = settle(ROBOT, inverse(ROBOT, KNOBS, chart, 1.0, 0.0))
    assert fast.speed > 0.9 * np.nanmax(chart.speed)


def test_the_map_shows_what_settles_slowly_too():
    knobs = replace(KNOBS, damping=0.001)
    chart = motion_map(ROBOT, knobs)
    # A few orbits do not hold; after 38 cycles nine tenths would not have settled.
    assert np.isnan(chart.speed).mean() < 0.02
    there = settle(ROBOT, placed(knobs, chart.offset[23], chart.phase[27]))
    assert chart.speed[23, 27] == pytest.approx(there.speed, rel=1e-5)


def test_a_drawn_path_leaves_out_what_nobody_sees(circular):
    whole, detail = circular.path(), 0.01
    drawn = circular.path(detail)
    assert len(drawn) < 0.5 * len(whole)
    away = np.linalg.norm(whole[:, None] - drawn[None], axis=2).min(axis=1)
    assert away.max() <= detail
    assert circular.end() == pytest.approx(whole[-1], abs=1e-12)
    # Where a period is less than that, some are left out whole.
    coarse = circular.path(0.08)
    assert len(coarse) < 76 and np.linalg.norm(np.diff(coarse, axis=0), axis=1).min() > 0.08


def test_ghosts_go_where_their_models_go():
    path = ghost(ROBOT, KNOBS, "decoupled").path()
    run = rr.sweep(rr.models.DecoupledModels(ROBOT), offset=np.pi / 4, progress=False)
    steps = np.diff(path.reshape(-1, 36, 2).mean(axis=1), axis=0)
    speed = np.linalg.norm(steps, axis=1).mean() / (np.pi / 4)
    assert speed == pytest.approx(float(run.speed), rel=1e-3)
    with pytest.raises(Refusal, match="pivoting"):
        shell = rr.Ellipsoid((0.12, 0.12, 0.14))
        ghost(
            rr.Robot.from_urdf(rr.urdf_path("rrrobot"), shell=shell),
            replace(KNOBS, body=(), damping_kind="body"), "pivoting",
        )  # fmt: skip


def volume(shape):
    points, faces = triangles(shape)
    a, b, c = (points[faces[:, k]].astype(float) for k in range(3))
    return float(np.sum(np.einsum("ij,ij->i", a, np.cross(b, c))) / 6)


def test_triangles_close_their_shapes_and_look_outwards():
    # A 48-gon's area is 0.9971 of its circle's.
    box = {"type": "BoxGeometry", "width": 1.0, "height": 2.0, "depth": 3.0}
    ball = {"type": "SphereGeometry", "radius": 2.0}
    rod = {"type": "CylinderGeometry", "radiusTop": 1.0, "radiusBottom": 1.0, "height": 2.0}
    cone = {"type": "CylinderGeometry", "radiusTop": 0, "radiusBottom": 1.0, "height": 3.0}
    assert volume(box) == pytest.approx(6.0)
    assert volume(ball) == pytest.approx(32 / 3 * np.pi, rel=0.01)
    assert volume(rod) == pytest.approx(2 * np.pi, rel=0.01)
    assert volume(cone) == pytest.approx(np.pi, rel=0.01)
    corners = np.array(((0.0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)))
    faces = np.array(((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)))
    assert volume(mesh(corners, faces)) == pytest.approx(1 / 6)


def test_a_taken_port_and_other_bad_input():
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        with pytest.raises(rr.OutputError, match=f"port {port}"):
            rr.laboratory(ROBOT, port=port)
    with pytest.raises(rr.ParameterError, match="port is 0"):
        rr.laboratory(ROBOT, port=0)
    with pytest.raises(rr.ModelError, match="must be a Robot"):
        rr.laboratory("rrrobot")
    stiff = rr.Robot.from_urdf(rr.urdf_path("rrrobot"), shell=rr.Sphere(0.12), legs=())
    with pytest.raises(rr.ModelError, match="no legs"):
        rr.laboratory(stiff)


def test_without_viser_it_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "viser", None)
    with pytest.raises(rr.MissingExtraError, match="pip install"):
        rr.laboratory(ROBOT)
