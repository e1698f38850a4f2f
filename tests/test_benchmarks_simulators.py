"""What is sent to other simulators, what comes back, and their robots, without the simulators."""

import json
import sys

import numpy as np
import pinocchio as pin
import pytest

import rrrobot as rr
from benchmarks import common, simulators
from benchmarks.drake_peer import simulate as by_drake
from benchmarks.exudyn_peer import rolling_jacobian, slip
from benchmarks.jiminy_peer import euler_torque, urdf
from benchmarks.peer_job import Job, as_json, euler_of_quaternions, euler_rates_map, motion
from benchmarks.pinocchio_peer import model_of
from benchmarks.pinocchio_peer import simulate as by_pinocchio
from rrrobot.rotations import euler_from_rotation


@pytest.fixture
def circular():
    return simulators.job(simulators.CASES[0], 1)


def short(job, cycles, **settings):
    plain = json.loads(as_json(job))
    return Job(**{**plain, "cycles": cycles, "counted": cycles, "settings": settings})


def test_importing_a_peer_needs_no_simulator():
    assert callable(by_drake)
    assert not {"pydrake", "exudyn", "jiminy_py"} & set(sys.modules)


def test_a_job_survives_being_sent(circular):
    again = Job(**json.loads(as_json(circular)))
    np.testing.assert_array_equal(again.start, circular.start)
    assert again.settings == circular.settings and again.steps == circular.steps


@pytest.mark.parametrize("case", simulators.CASES, ids=lambda c: f"{c.peer}, {c.model}")
def test_samples_fall_onto_steps(case):
    job = simulators.job(case, 0)
    assert case.peer in simulators.PEERS
    assert not case.fixed or job.steps % job.settings["samples"] == 0


def test_summed_acceleration_passes_through_the_gait(circular):
    h = circular.step
    angle = circular.legs(0.0)[0]
    rate = (angle - circular.legs(-h)[0]) / h
    for i in range(500):
        rate = rate + h * circular.summed_acceleration() * circular.legs(i * h)[2]
        angle = angle + h * rate
    np.testing.assert_allclose(angle, circular.legs(500 * h)[0], atol=1e-11)


def test_motion_takes_cycle_means(circular):
    t = np.linspace(0.0, circular.cycles * circular.period, circular.cycles * 20 + 1)
    wobble = 0.1 * np.sin(circular.omega * t)
    yaw = 0.5 * t + 3.0 * wobble
    places = np.column_stack((0.3 * t + wobble, 0.4 * t - wobble, (yaw + np.pi) % (2 * np.pi)))
    found = motion(places, circular)
    assert found["speed"] == pytest.approx(0.5) and found["yaw_rate"] == pytest.approx(0.5)
    with pytest.raises(ValueError, match="samples"):
        motion(places[:-1], circular)


def a_state(seed=3):
    rng = np.random.default_rng(seed)
    quaternion = pin.Quaternion(pin.rpy.rpyToMatrix(*rng.uniform(-1.0, 1.0, 3)))
    return quaternion, rng.normal(size=3)


def test_euler_angles_and_their_damping():
    quaternion, omega_body = a_state()
    rotation = quaternion.toRotationMatrix()
    euler = euler_from_rotation(rotation)
    np.testing.assert_allclose(euler_of_quaternions(quaternion.coeffs()[None])[0], euler)
    rates_map = np.linalg.solve(euler_rates_map(euler[1], euler[2]), rotation)
    torque = euler_torque(*quaternion.coeffs(), *omega_body)
    np.testing.assert_allclose(torque, -rates_map.T @ rates_map @ omega_body, rtol=1e-12)


def test_exudyn_rolls_as_the_library_does():
    roll, pitch, yaw = 0.3, -0.4, 0.8
    rates = np.array((0.5, -0.7, 0.2))
    centre = 0.12 * np.cross(euler_rates_map(pitch, yaw) @ rates, (0.0, 0.0, 1.0))
    q = (0.1, 0.2, 0.12, yaw, pitch, roll, 1.0, 1.1)
    v = (*centre, rates[2], rates[1], rates[0], 3.0, 4.0)
    np.testing.assert_allclose(slip(q, v, 0.12), 0.0, atol=1e-15)
    faster = np.add(v, (0.5, -0.25, 9.0, 0.0, 0.0, 0.0, 0.0, 0.0))
    np.testing.assert_allclose(slip(q, faster, 0.12), (0.5, -0.25))
    np.testing.assert_allclose(rolling_jacobian(q, 0.12) @ faster, (0.5, -0.25))


@pytest.mark.parametrize(
    "model_from",
    [model_of, lambda job: pin.buildModelFromXML(urdf(job), pin.JointModelFreeFlyer())],
    ids=["pinocchio", "jiminy"],
)
def test_robots_are_the_library_s(circular, model_from):
    model, ours = model_from(circular), rr.Robot.from_parameters().model
    quaternion, omega = a_state()
    q = np.concatenate(((0.1, 0.2, 0.3), quaternion.coeffs(), (0.9, 1.3)))
    v = np.concatenate(((0.4, 0.5, 0.6), omega, (1.0, -2.0)))
    a = np.linspace(-1.0, 1.0, 8)
    there = pin.rnea(model, model.createData(), q, v, a)
    np.testing.assert_allclose(there, pin.rnea(ours, ours.createData(), q, v, a), atol=1e-12)


def test_pinocchio_alone_rolls_only_with_a_correction(circular):
    held = by_pinocchio(short(circular, 2, method="CONTACT_3D", frequency=500.0))
    free = by_pinocchio(short(circular, 2, method="CONTACT_3D"))
    setting = common.lower(common.full_model())
    gaits = common.PAPER_GAITS.take([1]).gaits()
    ours = common.engine_motion(common.engine(setting, gaits, cycles=2, counted=2))
    assert held["speed"] == pytest.approx(ours.speed[0], rel=0.02)
    assert held["height"][0] > 0.1199 and free["height"][0] < 0.1
    assert held["leg_error"] < 1e-5
