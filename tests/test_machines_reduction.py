"""Connections of machines: published values, small loops, and three ways to one end."""

import numpy as np
import pytest

import rrrobot as rr
from tests.some import some

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


WAG = rr.SinusoidalGait(offset=(0.3, 0.8, -0.2), amplitude=(0.5, 0.3, 0.4), angular_frequency=2.0,
                        phase=(0.0, 1.0, 2.0))  # fmt: skip
PRINCIPAL = {
    "snake, circle": ("kinematic_snake", {}, "circle"),
    "snake, turn": ("kinematic_snake", {}, "turn"),
    "satellite": ("satellite", {}, "circle"),
    "satellite with two legs": ("legged_satellite", {}, "circular"),
    "cat": ("falling_cat", {}, WAG),
    "submarine, rotors": ("submarine", {"h": 0.0}, "turn"),
    "submarine, moving mass": ("submarine", {"mp": 5.0, "h": 0.0}, "circle"),
}


@pytest.mark.parametrize("which", some(PRINCIPAL, by_default=("satellite",)))
def test_line_area_and_dynamics_agree(which):
    name, parts, gait = PRINCIPAL[which]
    machine = rr.machines.by_name(name, **parts)
    drive = machine.gaits[gait] if isinstance(gait, str) else gait
    form = reduction(machine)
    line = form.line(drive)
    dynamics = machine.simulate(drive, drive.period, sample_interval=drive.period).pose[-1]
    area = form.area(drive)
    # A quaternion and its negative are one orientation.
    area[3:] *= np.sign(area[3:] @ line[3:] or 1.0)
    dynamics[3:] *= np.sign(dynamics[3:] @ line[3:] or 1.0)
    assert np.abs(line - machine.model.start(machine._pose(None))[: line.size]).max() > 1e-4
    np.testing.assert_allclose(dynamics, line, atol=1e-8)
    np.testing.assert_allclose(area, line, atol=1e-8)


def test_a_small_loop_moves_by_the_curvature():
    snake = reduction(rr.machines.kinematic_snake())
    centre, size = np.array((0.9, 0.5)), 1e-3
    loop = rr.SinusoidalGait(offset=centre, amplitude=size, angular_frequency=1.0,
                             phase=(np.pi / 2, 0.0))  # fmt: skip
    moved = snake.line(loop)
    np.testing.assert_allclose(moved / (-np.pi * size**2), snake.curvature(centre), atol=3 * size)
