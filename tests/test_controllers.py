"""Drives with memory against exact references: sampled and continuous, delayed, disturbed."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import rrrobot as rr

# Its inertia is far from that of 50 kg, on purpose.
pytestmark = pytest.mark.filterwarnings("ignore::rrrobot.errors.UrdfWarning")

KP, KI, KD, GOAL, J = 2.0, 4.0, 0.1, 1.0, 0.01


def _inertia(j: float) -> str:
    return f'<inertia ixx="{j}" ixy="0" ixz="0" iyy="{j}" iyz="0" izz="{j}"/>'


URDF = f"""<robot name="r"><link name="body"><inertial><mass value="50"/>{_inertia(1e9)}</inertial>
</link><link name="wheel"><inertial><mass value="0.1"/>{_inertia(J)}</inertial></link>
<joint name="j" type="continuous"><parent link="body"/><child link="wheel"/><axis xyz="0 1 0"/>
</joint></robot>"""
# The body is heavy, so that the wheel's motion is J phi_ddot = tau to 1e-11.


@pytest.fixture(scope="module")
def wheel() -> rr.FullModel:
    return rr.FullModel(rr.Robot.from_urdf(URDF, shell=rr.Sphere(0.2)), damping=None)


class Integral:
    """PI and rate feedback as in a microcontroller: its memory is in itself."""

    sample_time = 0.01

    def __init__(self):
        self.sum, self.times = 0.0, []

    def __call__(self, s):
        error = GOAL - s.leg_angle[0]
        self.sum += error * (self.sample_time if self.times else 0.0)
        self.times.append(s.time)
        return np.array([KP * error + KI * self.sum - KD * s.leg_rate[0]])


def sampled_reference(n: int, first: float, delay: int = 0):
    """Angles and torques at the instants; exact, as the torque is constant in between."""
    y, total, angles, torques, queue = np.zeros(2), 0.0, [], [], [0.0] * delay
    for k in range(n + 1):
        error = GOAL - y[0]
        total += error * (0.01 if k else first)
        queue.append(KP * error + KI * total - KD * y[1])
        u = queue.pop(0)
        angles.append(y[0])
        torques.append(u)
        a = u / J
        y = np.array((y[0] + 0.01 * y[1] + a * 0.01**2 / 2, y[1] + 0.01 * a))
    return np.array(angles), np.array(torques)


def run(model, law, duration=2.0, interval=0.01, **options):
    drive = rr.LegTorques(law, angle=(0.0,), feedback=not isinstance(law, rr.drive.TorqueLaw))
    start = {} if "state" in options else {"start": "rest"}
    return rr.simulate(model, drive, duration, interval, **start, **options)


def continuous() -> rr.drive.PID:
    return rr.drive.PID(GOAL, kp=KP, ki=KI, kd=KD)


def test_continuous_pid_is_the_augmented_equation(wheel):
    t = run(wheel, continuous())
    s = solve_ivp(
        lambda _, y: [y[1], (KP * (GOAL - y[0]) + KI * y[2] - KD * y[1]) / J, GOAL - y[0]],
        (0, 2), [0, 0, 0], method="DOP853", rtol=1e-12, atol=1e-13, t_eval=t.time,
    )  # fmt: skip
    torque = KP * (GOAL - s.y[0]) + KI * s.y[2] - KD * s.y[1]
    assert np.abs(t.leg_angle[:, 0] - s.y[0]).max() < 1e-9
    assert np.abs(t.memory[:, 0] - s.y[2]).max() < 1e-9
    assert np.abs(t.leg_torque[:, 0] - torque).max() < 1e-9
    assert t.leg_torque[0, 0] == KP * GOAL


def test_a_controller_that_remembers_is_called_in_order_and_held(wheel):
    law = Integral()
    t = run(wheel, law)
    angles, torques = sampled_reference(200, 0.0)
    assert np.abs(t.leg_angle[:, 0] - angles).max() < 1e-9
    assert np.abs(t.leg_torque[:, 0] - torques).max() < 1e-9
    assert t.leg_torque[0, 0] == KP * GOAL
    # A copy was called: the next run starts alike.
    assert law.times == []
    seen = t.final_state.law.function.times
    np.testing.assert_allclose(seen, 0.01 * np.arange(201), rtol=1e-14)
    np.testing.assert_array_equal(run(wheel, law).leg_angle, t.leg_angle)


def test_held_pid_between_the_samples_too(wheel):
    t = run(wheel, rr.drive.PID(GOAL, kp=KP, ki=KI, kd=KD, sample_time=0.01), interval=0.0025)
    angles, torques = sampled_reference(200, 0.01)
    assert np.abs(t.leg_angle[::4, 0] - angles).max() < 1e-9
    held = np.repeat(torques, 4)[: len(t)]
    assert np.abs(t.leg_torque[:, 0] - held).max() < 1e-9


@pytest.mark.parametrize("delay", [0, 1, 3])
def test_a_delay_of_whole_samples(wheel, delay):
    law = rr.drive.Delayed(rr.drive.PID(GOAL, kp=KP, ki=KI, kd=KD, sample_time=0.01), 0.01 * delay)
    t = run(wheel, law, 0.5)
    angles, torques = sampled_reference(50, 0.01, delay)
    assert np.abs(t.leg_angle[:, 0] - angles).max() < 1e-9
    assert np.abs(t.leg_torque[:, 0] - torques).max() < 1e-9


def test_a_delay_of_any_length_shifts_the_steps(wheel):
    """An open-loop staircase, delayed by 2.5 samples."""

    class Stairs(rr.drive.TorqueLaw):
        sample_time = 0.01

        def initial_memory(self, n_legs):
            return rr.drive.Memory(held=np.zeros(1))

        def tick(self, state, memory, clock, k):
            return rr.drive.Memory(held=np.array([k + 1.0]))

        def torque(self, state, memory):
            return 1e-3 * memory.held

    t = run(wheel, rr.drive.Delayed(Stairs(), 0.025), 0.1, 0.005)
    steps = np.floor((np.arange(21) - 5 + 1e-9) / 2) + 1
    np.testing.assert_allclose(t.leg_torque[:, 0], 1e-3 * np.maximum(steps, 0), atol=1e-15)


def test_a_disturbance_is_its_seed(wheel):
    def push(seed):
        return rr.drive.SumOfLaws(
            continuous(), rr.drive.RandomTorques(0.05, sample_time=0.02, seed=seed)
        )

    one, same, other = (run(wheel, push(seed), 0.5) for seed in (3, 3, 4))
    np.testing.assert_array_equal(one.leg_angle, same.leg_angle)
    assert np.abs(one.leg_angle - other.leg_angle).max() > 1e-4
    coarse = run(wheel, push(3), 0.5, rtol=1e-8)
    np.testing.assert_array_equal(coarse.memory[:, -1], one.memory[:, -1])
    draws = one.memory[::2, -1]
    assert np.ptp(draws) > 0.05
    np.testing.assert_array_equal(one.memory[1::2, -1], draws[:25])


@pytest.mark.parametrize("hidden", [False, True])
@pytest.mark.parametrize("cut", [pytest.param(0.5, marks=pytest.mark.slow), 0.505])
def test_a_run_with_memory_is_continued(wheel, hidden, cut):
    def law():
        if hidden:
            return Integral()
        pid = rr.drive.PID(GOAL, kp=KP, ki=KI, kd=KD, sample_time=0.01)
        return rr.drive.SumOfLaws(rr.drive.Delayed(pid, 0.013), continuous(),
                            rr.drive.RandomTorques(0.05, sample_time=0.007, seed=1))  # fmt: skip

    whole = run(wheel, law(), 1.0, 0.005)
    first = run(wheel, law(), cut, 0.005)
    second = run(wheel, law(), 1.0 - cut, 0.005, state=first.final_state)
    n = len(first) - 1
    np.testing.assert_allclose(second.time, whole.time[n:], rtol=1e-15)
    np.testing.assert_allclose(second.leg_angle, whole.leg_angle[n:], atol=1e-10)
    np.testing.assert_allclose(second.leg_torque, whole.leg_torque[n:], atol=1e-9)


def test_bad_laws(wheel):
    with pytest.raises(rr.GaitError, match="sample_time is 0"):
        rr.LegTorques(lambda t: 0, angle=(0,), sample_time=0)
    with pytest.raises(rr.GaitError, match="a TorqueLaw sees the state"):
        rr.LegTorques(continuous(), angle=(0,), sample_time=0.1)
    with pytest.raises(rr.GaitError, match="needs a function"):
        rr.LegTorques(1.0, angle=(0,), sample_time=0.1)
    with pytest.raises(rr.GaitError, match="one sample time"):
        rr.drive.Delayed(continuous(), 0.1)
    with pytest.raises(rr.GaitError, match="kp of the PID has 2 entries for 1 legs"):
        run(wheel, rr.drive.PID(GOAL, kp=(1, 2)))
    with pytest.raises(rr.GaitError, match="seed is -1"):
        rr.drive.RandomTorques(0.1, sample_time=0.1, seed=-1)


class Naive:
    """What everybody writes first: an integral by the time since the last call."""

    def __init__(self):
        self.sum, self.last, self.calls = 0.0, 0.0, 0

    def __call__(self, state):
        self.calls += 1
        error = GOAL - state.leg_angle[0]
        self.sum += error * (state.time - self.last)
        self.last = state.time
        return np.array([KP * error + KI * self.sum - KD * state.leg_rate[0]])


class Zero(Naive):
    """Holds its output for 10 ms by itself."""

    next, out = 0.0, np.zeros(1)

    def __call__(self, state):
        if state.time >= self.next - 1e-12:
            self.out, self.next = super().__call__(state), self.next + 0.01
        return self.out


class Filtered(rr.drive.TorqueLaw):
    """A law of the house that keeps a filter's output in itself instead of in its memory."""

    seen = 0.0

    def torque(self, state, memory):
        self.seen += 0.01 * (state.leg_angle[0] - self.seen)
        return [KP * (GOAL - self.seen)]


class Late(Naive):
    """Remembers only from 0.5 s on."""

    def __call__(self, state):
        early = [KP * (GOAL - state.leg_angle[0])]
        return early if state.time < 0.5 else super().__call__(state)


@pytest.mark.parametrize(
    "law", [Naive(), Zero(), Filtered(), Late()], ids=lambda x: type(x).__name__
)
@pytest.mark.parametrize("options", [{}, {"step": 0.01}], ids=["adaptive", "fixed"])
def test_a_law_that_remembers_in_itself_is_refused(wheel, law, options):
    with pytest.raises(rr.GaitError, match=r"remembers: asked twice .* give sample_time="):
        run(wheel, law, **options)


def test_a_law_that_remembers_is_right_with_a_sample_time(wheel):
    """The advice of the refusal, against the equation of the sampled law."""
    drive = rr.LegTorques(Naive(), angle=(0.0,), feedback=True, sample_time=0.01)
    t = rr.simulate(wheel, drive, 2.0, start="rest")
    assert np.abs(t.leg_angle[:, 0] - sampled_reference(200, 0.0)[0]).max() < 1e-9


def test_a_law_may_count_its_calls_and_may_not_write_what_it_sees(wheel):
    calls = []

    def counts(state):
        calls.append(state.time)
        return [KP * (GOAL - state.leg_angle[0])]

    plain = run(wheel, lambda s: [KP * (GOAL - s.leg_angle[0])], 0.5)
    np.testing.assert_array_equal(run(wheel, counts, 0.5).leg_angle, plain.leg_angle)
    assert len(calls) > 100

    def writes(state):
        error = state.leg_angle
        error -= GOAL
        return -KP * error

    with pytest.raises(ValueError, match="read-only"):
        run(wheel, writes)


def test_a_gait_that_remembers_is_refused():
    class Ramp:
        angle = 0.0

        def __call__(self, time):
            self.angle += 1e-6
            return [self.angle], [0.0], [0.0]

    with pytest.raises(rr.GaitError, match="depend on the time alone"):
        rr.CallableGait(Ramp(), n_legs=1)
