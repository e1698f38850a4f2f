"""A lone body that rolls by itself, by the momentum engine: thirty times as fast as the KKT system.

The engine's steps are fixed. Here they follow the motion: the samples are taken a stretch at a
time, the first and the last interval of each are gone over again with half the step, and where the
two differ by more than the tolerances allow, the stretch is taken again with shorter steps.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from rrrobot.checks import Array
from rrrobot.constraints import RollingContact
from rrrobot.contact.ground import Plane
from rrrobot.contact.surfaces import Ellipsoid, Sphere
from rrrobot.drive.damping import BodyRateDamping
from rrrobot.drive.gaits import StillLegs
from rrrobot.integrate import SHORTEST_STEP, Integration, Stepping
from rrrobot.machines.mechanism import Mechanism
from rrrobot.machines.tree import Tree
from rrrobot.models.full import FullModel
from rrrobot.robot.robot import Robot
from rrrobot.rotations import rotation_from_quaternion

_STRETCH, _SECONDS = 25, 0.5
"""Sample intervals, and about how long [s], that are taken at a time: a rattle grows and dies
within a second, and only the ends of a stretch are gone over again."""
_ORDER = 8
_STRICT = 0.02
"""Part of the tolerances that is used: an adaptive DOP853, which overestimates its errors, keeps
within about as much."""
_SAFE = 0.8
"""Part of the step that the error allows that is taken."""


def rolls_alone(tree: Tree, model: Mechanism) -> bool:
    """Whether the engine has the very equations of a machine: one body, a sphere or an ellipsoid
    about its frame's origin, on a plane that does not move."""
    contact = model.rolling
    return (
        not tree.joints
        and type(contact) is RollingContact
        and len(model.constraints) == 1
        and type(contact.surface) in (Sphere, Ellipsoid)
        and type(contact.ground) is Plane
        and model.fluid is None
        and (model.damping is None or type(model.damping) is BodyRateDamping)
    )


def roll(
    tree: Tree, model: Mechanism, start: Array, times: Array, stepping: Stepping
) -> Integration:
    """States (n, 13) from a start (13,): those of `integrate` on the machine's own equations."""
    rolling = _Rolling(tree, model)
    used = stepping.checked()
    states = np.empty((times.size, start.size))
    states[0] = start
    y, done, evaluations, stop, interrupted = rolling.of(start), 0, 0, None, False
    step = min(used.max_step, float(np.diff(times).max()))
    try:
        while done < times.size - 1 and stop is None:
            interval = float(times[done + 1] - times[done])
            stretch = max(1, min(_STRETCH, int(_SECONDS / interval)))
            last = min(done + stretch, times.size - 1)
            span = times[done : last + 1]
            with np.errstate(over="ignore", invalid="ignore"):
                # A step that is far too long may run away; it is taken again.
                run = rolling.run(y, span, step)
            evaluations += run.evaluations
            stop = run.stop
            if stop is not None and step > 1e-3:
                step, stop = 0.3 * step, None
                continue
            error = rolling.error(y, span, run, step, used)
            if not error <= 1.0:
                step *= max(0.2, _SAFE * error ** (-1 / _ORDER)) if np.isfinite(error) else 0.2
                if step < SHORTEST_STEP:
                    stop = f"the step fell to {step:.3g} s: the motion is too fast"
                continue
            states[done + 1 : done + len(run.states)] = rolling.back(run.states[1:])
            done, y = done + len(run.states) - 1, run.states[-1]
            step = min(used.max_step, step * min(2.0, _SAFE * max(error, 1e-9) ** (-1 / _ORDER)))
    except KeyboardInterrupt:
        stop, interrupted = "the simulation was interrupted", True
    n = done + 1
    return Integration(
        times[:n], states[:n], float(times[done]), states[done], evaluations, stop, interrupted
    )


class _Watcher:
    """Lets the engine run."""

    def sampled(self, first: int, states: Array) -> None:
        pass

    def stepped(self, ends: Array) -> tuple[int, str] | None:
        return None


class _Rolling:
    """A machine as a `FullModel` without legs; its state is (quaternion, contact (2,), omega)."""

    run: Callable[[Array, Array, float], Integration]

    def __init__(self, tree: Tree, model: Mechanism) -> None:
        from rrrobot.momentum.run import run

        contact = model.rolling
        assert contact is not None and isinstance(contact.ground, Plane)
        self.surface, self.normal = contact.surface, contact.ground.normal_vector
        robot = Robot(
            urdf=tree.urdf("body"), shell=self.surface, legs=(), shell_link=tree.base.name,
            shell_center=np.zeros(3),
        )  # fmt: skip
        gravity = -float(model.model.gravity.linear[2])
        self.ground = Plane(self.normal, gravity=gravity)
        self.model = FullModel(robot, ground=self.ground, damping=model.damping)
        still, watcher = StillLegs(()), _Watcher()
        self.run = lambda y, times, step: run(self.model, still, y, times, step, observer=watcher)[
            0
        ]

    def of(self, state: Array) -> Array:
        """The engine's state (9,) of a machine's (13,)."""
        arm = self._arm(state[3:7])
        place = self.ground.coordinates(state[:3] + arm)
        return np.concatenate((state[3:7], place, state[10:13]))

    def back(self, states: Array) -> Array:
        """The machine's states (n, 13) of the engine's (n, 9)."""
        found = np.empty((len(states), 13))
        for row, y in zip(found, states, strict=True):
            rotation = rotation_from_quaternion(y[:4])
            arm = self._arm(y[:4])
            row[:3] = self.ground.point(y[4:6]) - arm
            row[3:7] = y[:4]
            # The contact stands still: v + omega x rho = 0, in the body's axes.
            row[7:10] = np.cross(rotation.T @ arm, y[6:])
            row[10:] = y[6:]
        return found

    def error(
        self, y: Array, times: Array, run: Integration, step: float, stepping: Stepping
    ) -> float:
        """Largest difference from half the step over the first and the last interval, in parts of
        what the tolerances allow in each step."""
        worst = 0.0
        for i in {1, len(times) - 1}:
            begin = y if i == 1 else run.states[i - 1]
            interval = float(times[i] - times[i - 1])
            steps = max(1.0, np.ceil(interval / step - 1e-9))
            fine = self.run(begin, times[i - 1 : i + 1], interval / steps / 2).states[-1]
            allowed = _STRICT * (stepping.atol + stepping.rtol * np.abs(fine))
            off = float(np.max(np.abs(fine - run.states[i]) / allowed)) / steps
            worst = off if off > worst or np.isnan(off) else worst
        return worst

    def _arm(self, quaternion: Array) -> Array:
        return self.surface.arm(rotation_from_quaternion(quaternion), self.normal)
