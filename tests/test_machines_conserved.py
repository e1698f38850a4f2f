"""What machines keep over a minute: energy, momenta, and the integrals of rolling, to 1e-10."""

import numpy as np
import pytest

import rrrobot as rr
from tests.some import some
from tests.test_machines_space import matrix, momenta, momentum_about_the_contact, rpy, zxy

HALF = np.deg2rad(0.5)
MINUTE = 60.0


def kept(values, part=1e-10):
    values = np.array(values)
    assert np.abs(values - values[0]).max() < part * np.linalg.norm(np.atleast_1d(values[0]))


def free(name, pose=None, rtol=1e-12, **start):
    """A minute of a machine that no motor moves; its pose a rotation."""
    machine = rr.machines.by_name(name)
    start |= {} if pose is None else {"pose": machine.at(pose)}
    return machine.simulate(None, MINUTE, sample_interval=0.5, rtol=rtol, atol=rtol / 10, **start)


TUMBLING = {"pose": rpy(0.1, 0.2, 0.3), "start": (3, -2, 4)}
FREE = {
    "snakeboard": {"shape": (0.0, 0.3, -0.2), "shape_rates": (1.0, 0.2, -0.1)},
    "roller_racer": {"shape": (0.3,), "shape_rates": (0.5,)},
    "trikke": {"shape": (0.3, 0.2), "shape_rates": (0.5, -0.4)},
    "kinematic_snake": {"shape": (1.0, 0.5), "shape_rates": (0.2, 0.1)},
    "chaplygin_sleigh": {"start": (0.4, 0.0, 1.3)},
    "rolling_disc": {"pose": zxy(0.4, 0.35, 2.1), "start": (0.5, -6.0, 1.2)},
    "chaplygin_sphere": TUMBLING,
    "routh_sphere": {"pose": rpy(0.3, 0.2, 0.5), "start": (0.5, 1, 6)},
    "rattleback": {"pose": zxy(0, HALF, -HALF), "start": (0, 0, 5.0)},
    "pendulum_ball": {"shape": (0.3, 0.4), "start": (1, -2, 0.5)},
    "rotor_ball": {"start": (1, -2, 0.5), "shape_rates": (30, -20, 10)},
    "satellite": {"shape": (0.3, 0.2), "shape_rates": (0.5, -0.4)},
    "legged_satellite": {"shape": (0.3, 0.2), "shape_rates": (0.5, -0.4), "start": (0.1, 0.2, 0.3)},
    "submarine": {"start": (0.3, -0.4, 0.5), "shape_rates": (20, -10, 5)},
    "rrrobot": {"shape": (0.8, 0.7), "start": (0.5, 0.3, 0.2)},
}
QUICK = ("roller_racer", "trikke", "kinematic_snake", "satellite")


@pytest.mark.parametrize("name", some(FREE, by_default=QUICK))
def test_energy_is_kept_for_a_minute(name):
    t = free(name, **FREE[name])
    kept(t.energy)
    assert t.violation.max() < 1e-12 > t.gap.max()


@pytest.mark.slow
def test_a_ball_on_a_slope_turns_height_into_speed():
    ball = rr.machines.ball_on_slope()
    t = ball.simulate(None, MINUTE, sample_interval=1.0, rtol=1e-12)
    lost = 9.81 * ball.tree.base.mass * (t.pose[0, 2] - t.pose[-1, 2])
    assert np.abs(t.energy - t.energy[0]).max() < 1e-10 * lost


@pytest.mark.slow
def test_a_ball_on_a_turntable_keeps_the_centre_of_its_circle():
    # a = (2/7) Omega z x v, so v - (2/7) Omega z x x is constant; so is its spin about z.
    ball = rr.machines.turntable_ball(rate=2.0)
    t = ball.simulate(None, MINUTE, pose=(0.3, 0.1, 0.1, 0, 0, 0, 1), start=(2.0, 1.0, 0.7),
                      sample_interval=1.0, rtol=1e-13, atol=1e-14)  # fmt: skip
    x, R = t.pose[:, :3], [matrix(q) for q in t.quaternion]
    v, w = (np.array([r @ b for r, b in zip(R, part, strict=True)])
            for part in (t.body_velocity[:, :3], t.body_velocity[:, 3:]))  # fmt: skip
    kept(v - 4 / 7 * np.cross((0, 0, 1), x))
    kept(w[:, 2])


@pytest.mark.slow
def test_rolling_balls_keep_their_momentum_about_the_contact():
    ball = rr.machines.chaplygin_sphere()
    t = free("chaplygin_sphere", **TUMBLING)
    kept(momentum_about_the_contact(t, ball.tree.base.inertia, 1.0, 0.2))
    # Rotors push without changing it, so from rest it stays zero.
    ball = rr.machines.rotor_ball()
    t = ball.simulate(ball.gaits["circle"], MINUTE, sample_interval=1.0)
    push = [8e-4 * matrix(q) @ rate for q, rate in zip(t.quaternion, t.shape_rates, strict=True)]
    K = momentum_about_the_contact(t, 3 * (0.009,), 1.0, 0.15) + push
    assert np.abs(K).max() < 1e-10 * np.abs(push).max()


FLOATING = {"satellite": "circle", "legged_satellite": "circular", "falling_cat": "roll"}


@pytest.mark.parametrize("name", some(FLOATING, by_default=("satellite",)))
def test_satellites_keep_no_momentum_from_rest(name):
    body = rr.machines.by_name(name)
    t = body.simulate(body.gaits[FLOATING[name]], MINUTE, sample_interval=1.0)
    base = body.model.n_base
    for z, v in map(body.model.split, t.states):
        momentum = body.model.mass_matrix(body.model.coordinates.to_q(z))[:base] @ v
        assert np.abs(momentum).max() < 1e-10


@pytest.mark.slow
def test_kirchhoff_keeps_both_momenta_of_a_balanced_submarine():
    boat = rr.machines.submarine(h=0.0)
    t = boat.simulate(rr.StillLegs((0.0,) * 3), MINUTE, pose=boat.at(rpy(0.1, 0.2, 0.3)),
                      start=(0.6, -0.2, 0.1, 0.3, -0.4, 0.5), sample_interval=1.0, rtol=1e-13,
                      atol=1e-14, max_step=0.03)  # fmt: skip
    both, R = momenta(t), [matrix(q) for q in t.quaternion]
    P = np.array([r @ p[:3] for r, p in zip(R, both, strict=True)])
    about = [
        r @ p[3:] + np.cross(x, r @ p[:3]) for r, p, x in zip(R, both, t.pose[:, :3], strict=True)
    ]
    for values in (P, about, np.sum(both[:, :3] * both[:, 3:], axis=1), t.energy):
        kept(values)
