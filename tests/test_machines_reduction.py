"""Connections of machines: published values, small loops, and three ways to one end."""

import numpy as np
import pytest

import rrrobot as rr

reduction = rr.machines.Reduction


def test_kinds_follow_by_computation():
    wanted = {
        "kinematic_snake": "kinematic",
        "snakeboard": "mixed",
        "roller_racer": "mixed",
        "trikke": "mixed",
        "satellite": "momentum",
        "falling_cat": "momentum",
    }
    assert {name: reduction(rr.machines.by_name(name)).kind for name in wanted} == wanted
    with pytest.raises(rr.ModelError, match="change with its pose"):
        reduction(rr.machines.rotor_ball())
    with pytest.raises(rr.ModelError, match="change with its pose"):
        reduction(rr.machines.submarine())


def test_snake():
    snake = reduction(rr.machines.kinematic_snake())
    a1, a2, L = 0.9, 0.5, 0.15
    D = np.sin(a1) * (1 + np.cos(a2)) + np.sin(a2) * (1 + np.cos(a1))
    A = np.array([[L * (1 + np.cos(a2)), -L * (1 + np.cos(a1))], [0, 0],
                  [np.sin(a2), np.sin(a1)]]) / D  # fmt: skip
    np.testing.assert_allclose(snake.connection((a1, a2)), A, atol=1e-14)
    np.testing.assert_allclose(
        snake.curvature((a1, a2)), (0.1807157376, 0.06671997806, -0.1371711628), atol=2e-10
    )
    with pytest.raises(rr.ConstraintError, match="the connection is singular"):
        snake.connection((0.4, -0.4))


def test_satellites():
    arms = reduction(rr.machines.satellite())
    np.testing.assert_allclose(
        arms.connection((0.7, -1.1))[2], (0.1742909192, 0.075334714), rtol=1e-9
    )
    assert arms.curvature((0.7, -1.1))[2] == pytest.approx(0.01898094999, rel=1e-9)
    legs = reduction(rr.machines.legged_satellite())
    np.testing.assert_allclose(
        legs.connection((0.9, 1.3))[3:],
        [[-0.0710671469, 0.05176885316], [-0.1860564904, -0.1992823783],
         [-0.1795857397, 0.198133479]], atol=2e-10,
    )  # fmt: skip


def test_submarine_with_a_moving_mass():
    boat = reduction(rr.machines.submarine(mp=5.0, h=0.0))
    assert boat.kind == "momentum"
    column = (0.06529355536, -0.0002912996166, 0.0003003261354, 0.0006248015767, 0.07997104734,
              0.06199936707)  # fmt: skip
    np.testing.assert_allclose(boat.connection((0.1, -0.05, 0.08))[:, 0], column, atol=1e-11)


def test_mixed_machines_have_their_known_free_directions():
    f, b, l = 0.5, -0.3, 0.2  # noqa: E741
    form = reduction(rr.machines.snakeboard()).at((0.4, f, b))
    known = np.array((2 * l * np.cos(f) * np.cos(b), l * np.sin(f + b), np.sin(f - b)))
    assert abs(form.free[:, 0] @ known) == pytest.approx(np.linalg.norm(known), rel=1e-14)
    racer = reduction(rr.machines.roller_racer()).at((0.6,))
    known = np.array((0.3 * np.cos(0.6) + 0.1, 0, np.sin(0.6)))
    assert abs(racer.free[:, 0] @ known) == pytest.approx(np.linalg.norm(known), rel=1e-14)


def test_an_impulsive_start_is_the_connection():
    for name in ("snakeboard", "roller_racer", "trikke"):
        machine = getattr(rr.machines, name)()
        gait = next(iter(machine.gaits.values()))
        first = gait(0.0)
        t = machine.simulate(gait, 0.01)
        A = reduction(machine).connection(first.angle)
        np.testing.assert_allclose(t.body_velocity[0], -A @ first.rate, atol=1e-14)


@pytest.mark.parametrize(
    ("name", "gait"),
    [
        pytest.param("kinematic_snake", "circle", marks=pytest.mark.slow),
        ("satellite", "circle"),
        ("legged_satellite", "circular"),
    ],
)
def test_line_area_and_dynamics_agree(name, gait):
    machine = getattr(rr.machines, name)()
    drive = machine.gaits[gait]
    form = reduction(machine)
    line = form.line(drive)
    dynamics = machine.simulate(drive, drive.period, sample_interval=drive.period).pose[-1]
    np.testing.assert_allclose(dynamics, line, atol=1e-9)
    if name != "legged_satellite":
        np.testing.assert_allclose(form.area(drive), line, atol=1e-8)


def test_a_small_loop_moves_by_the_curvature():
    snake = reduction(rr.machines.kinematic_snake())
    centre, size = np.array((0.9, 0.5)), 1e-3
    loop = rr.SinusoidalGait(offset=centre, amplitude=size, angular_frequency=1.0,
                             phase=(np.pi / 2, 0.0))  # fmt: skip
    moved = snake.line(loop)
    np.testing.assert_allclose(moved / (-np.pi * size**2), snake.curvature(centre), atol=3 * size)
