"""GaitBatchs of gaits on a robot's belly: where they go and how near they come to every limit."""

from __future__ import annotations

import os
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from copy import copy
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from rrrobot.belly.shapes import Shapes
from rrrobot.checks import Array
from rrrobot.drive.gaits import GaitBatch
from rrrobot.escape.capsules import Capsules, clearances
from rrrobot.models.base import Model
from rrrobot.momentum.batch import RESULT, Settled, lower, settled
from rrrobot.momentum.extremes import LOADS, extremes
from rrrobot.momentum.kernels import ANY, LIFT_OFF, OK
from rrrobot.momentum.terrain import BOULDER

COUNTED = 4
"""Cycles that are averaged."""
_STEPS = 12
_CLOSE_SAMPLES = 12
"""Instants of a cycle at which clearances are taken, at least."""
_SPARE = 1e-3
"""Of the links' distance, that is kept where capsules only tell how it changes [m]."""
_CHUNK = 64
"""Gaits that a thread takes at a time."""
_COLUMNS = [RESULT.index(name) for name in ("velocity_x", "velocity_y", "yaw_rate")]
_DECAYED = np.log(1e4)


class Outcome(NamedTuple):
    """What gaits do, one a row; NaN where the engine stopped."""

    travel: Array
    """v_x, v_y and yaw rate (n, 3) [m/s, rad/s]"""
    variation: Array
    """of the steps from cycle to cycle, over the step (n,)"""
    rocking: NDArray[np.complex128]
    """roll's and pitch's response, amplitude and phase as complex numbers (n, 2) [rad]"""
    tilt: Array
    """of the base's z axis: its lean (x, y) through the last cycle (n, steps, 2) [rad]"""
    status: Array
    """why the engine stopped, 0 if it did not (n,)"""
    normal: Array
    """least normal force over the weight (n,)"""
    friction: Array
    """coefficient needed (n,)"""
    torque: Array
    """largest motor torque of each leg (n, legs) [N m]"""
    power: Array
    """mean of the sum of |torque x rate| (n,) [W]"""
    height: Array
    """least height of each limb's capsules, the last column of the base's (n, limbs + 1) [m]"""
    apart: Array
    """least distance of capsules that may meet (n,) [m]"""

    @property
    def most_tilt(self) -> Array:
        """Largest tilt of the last cycle (n,) [rad]."""
        return np.asarray(np.linalg.norm(self.tilt, axis=2).max(axis=1))

    def rows(self, which: NDArray[Any]) -> Outcome:
        """Some of them."""
        return Outcome(*(part[which] for part in self))

    @staticmethod
    def joined(parts: Sequence[Outcome]) -> Outcome:
        """One after the other."""
        return Outcome(*(np.concatenate(columns) for columns in zip(*parts, strict=True)))


class Bench:
    """A model with the capsules of its links, ready for many gaits.

    Args:
        model: `FullModel` with damping, on any ground that the engine knows.
        capsules: of its links.
        limbs: how many there are.
        decay: of the slowest rocking mode [1/s]: gaits run until what they began with is decayed
            to 1e-4.
        rest: roll and pitch at which gaits begin (2,) [rad]; upright unless given. On a slope that
            is far from the rest, and a robot that rolls back turns, which never decays.

    Attributes:
        simulated: gaits so far, by this one and by those that `near` made of it.
    """

    def __init__(
        self,
        model: Model,
        capsules: Capsules,
        limbs: int,
        decay: float,
        rest: Array | None = None,
    ) -> None:
        self.model, self.capsules, self.decay, self.rest = model, capsules, decay, rest
        self.setting = lower(model)
        # Travel to 1e-6 is enough of what the general model confirms.
        self.setting = self.setting._replace(fineness=-(-self.setting.fineness // 2))
        self.weight = model.robot.mass * model.gravity
        self.limbs = limbs
        self._simulated = [0]
        terrain = self.setting.terrain
        self.curvature = 0.0
        if terrain is not None and terrain.ground == BOULDER:
            self.curvature = float(terrain.curvature)

    @property
    def simulated(self) -> int:
        """See above."""
        return self._simulated[0]

    @property
    def settle_time(self) -> float:
        """After which gaits count [s]."""
        return float(_DECAYED / self.decay)

    def __call__(self, gaits: GaitBatch, *, forces: bool = True, clearance: bool = True) -> Outcome:
        """What the gaits do; without forces or clearance, those are NaN."""
        n = gaits.n
        period = 2 * np.pi / gaits.angular_frequency
        cycles = np.ceil(self.settle_time / period).astype(np.int64) + COUNTED
        order = np.argsort(cycles, kind="stable")
        chunks = [order[i : i + _CHUNK] for i in range(0, n, _CHUNK)]

        def run(rows: NDArray[Any]) -> Outcome:
            some = gaits.rows(rows)
            return self._chunk(some, cycles[rows], forces=forces, clearance=clearance)

        if len(chunks) > 1:
            with ThreadPoolExecutor(os.cpu_count()) as pool:
                found = Outcome.joined(list(pool.map(run, chunks)))
        else:
            found = run(order)
        self._simulated[0] += n
        return found.rows(np.argsort(order, kind="stable"))

    def configurations(self, gaits: GaitBatch) -> Array:
        """Pinocchio's q at instants of the last cycle (n, instants, nq), for distances.

        The contact is put at the ground's origin, as turned about the vertical as may be: of planes
        and boulders, no distance depends on that.
        """
        n = gaits.n
        cycles = np.ceil(self.settle_time * gaits.angular_frequency / (2 * np.pi)).astype(np.int64)
        steps = _STEPS + 8 * (gaits.sine.shape[1] - 1)
        found = self._settled(gaits, cycles + COUNTED, steps)
        angle, normal, s = self._cycle(gaits, found.motion)
        model, index = self.model.model, self.model.legs
        out = np.tile(pin.neutral(model), (n, normal.shape[1], 1))
        up = self.model.ground.normal(np.zeros(3))
        origin = s + self.setting.tree.translation[0]
        for i, j in np.ndindex(out.shape[:2]):
            turn = pin.Quaternion.FromTwoVectors(normal[i, j], up)
            out[i, j, :3], out[i, j, 3:7] = turn.matrix() @ origin[i, j], turn.coeffs()
            index.write(out[i, j], angle[i, j])
        return out

    def still(self, offset: Array) -> tuple[Array, Array]:
        """Heights (n, limbs + 1) and separations (n,) of the legs held (n, legs), upright [m]."""
        pose = self.model.make_pose(np.zeros(3), np.zeros(2))
        origin = self.model.place(pose).configuration[:3]
        about = -self.setting.tree.translation[0]
        normal = self.model.ground.normal(np.zeros(3))
        n = len(offset)
        return clearances(
            self.setting.tree, self.capsules, self.limbs, offset[:, None],
            np.tile(normal, (n, 1, 1)), np.tile(origin + about, (n, 1, 1)), self.curvature,
        )  # fmt: skip

    def exact(self, shapes: Shapes, angle: Array) -> Array:
        """Distances by Coal of the links of each pair at legs' angles (n, legs): (n, pairs) [m]."""
        model = self.model.model
        q, data, apart = pin.neutral(model), model.createData(), shapes.geometry.createData()
        out = np.empty((len(angle), len(self.capsules.pairs)))
        for row, legs in zip(out, angle, strict=True):
            self.model.legs.write(q, legs)
            pin.computeDistances(model, data, shapes.geometry, apart, q)
            row[:] = [result.min_distance for result in apart.distanceResults]
        return out

    def near(self, shapes: Shapes, angle: Array, least: float) -> Bench:
        """A bench for motions near legs' angles (n, legs), that knows by Coal what is apart there.

        A capsule around a box is wider than the box. Where the capsules of a pair are nearer than
        twice that distance, the search sees by how much they come nearer than at these angles, and
        lets the links nearly touch.

        Args:
            shapes: of the capsules.
            angle: a posture, or the instants of a gait.
            least: distance that capsules are to keep [m].
        """
        own, whole = copy(self), self.capsules
        exact, extra = self.exact(shapes, angle), np.zeros(len(whole.pairs))
        for k, pair in enumerate(whole.pairs):
            own.capsules = whole._replace(pairs=pair[None], extra=np.zeros(1))
            gaps = own.still(angle)[1]
            if gaps.min() < 2 * least:
                extra[k] = (exact[:, k] - gaps).min() + least - _SPARE
        own.capsules = whole._replace(extra=extra)
        return own

    def cycle(self, gaits: GaitBatch) -> Array:
        """Legs' angles at instants of one gait's cycle (n, legs)."""
        turn = np.linspace(0.0, 2 * np.pi, _CLOSE_SAMPLES, endpoint=False)
        turns = np.multiply.outer(turn, np.arange(gaits.sine.shape[1]) + 1)
        return np.asarray(
            gaits.offset[0] + np.sin(turns) @ gaits.sine[0] + np.cos(turns) @ gaits.cosine[0]
        )

    def _settled(self, gaits: GaitBatch, cycles: NDArray[np.int64], steps: int) -> Settled:
        tilt = None if self.rest is None else np.tile(self.rest, (gaits.n, 1))
        return settled(
            self.setting, gaits, cycles=cycles, counted=COUNTED, steps=steps, tilt=tilt
        )  # fmt: skip

    def _chunk(
        self, gaits: GaitBatch, cycles: NDArray[np.int64], *, forces: bool, clearance: bool
    ) -> Outcome:
        n, legs = gaits.offset.shape
        steps = _STEPS + 8 * (gaits.sine.shape[1] - 1)
        found = self._settled(gaits, cycles, steps)
        values = dict(zip(RESULT, found.results.T, strict=True))
        status = np.where(values["status"] == LIFT_OFF, OK, values["status"])
        loads, torque = np.full((n, len(LOADS)), np.nan), np.full((n, legs), np.nan)
        if forces:
            # Forces of smooth motions are found between fewer instants than sharp shells' steps.
            motion = np.ascontiguousarray(found.motion[:, :: self.setting.fineness])
            loads = extremes(self.setting, gaits, motion, torque)
        up = found.motion[:, :, :3]
        height, apart = np.full((n, self.limbs + 1), np.nan), np.full(n, np.nan)
        if clearance:
            height, apart = self._clearances(gaits, found.motion)
        swing = [
            values[f"{axis}_amplitude"] * np.exp(1j * values[f"{axis}_phase"])
            for axis in ("roll", "pitch")
        ]
        lean = -up[:, :, :2] * (np.arccos(np.clip(up[:, :, 2], -1, 1)) / np.maximum(
            np.linalg.norm(up[:, :, :2], axis=2), 1e-12))[:, :, None]  # fmt: skip
        load = dict(zip(LOADS, loads.T, strict=True))
        out = Outcome(
            found.results[:, _COLUMNS], values["variation"], np.column_stack(swing), lean, status,
            load["normal_force"] / self.weight, load["friction"], torque, load["power"],
            height, apart,
        )  # fmt: skip
        for part in out:
            if part is not status:
                part[status != OK] = np.nan
        return out

    def _clearances(self, gaits: GaitBatch, motion: Array) -> tuple[Array, Array]:
        """Least heights (n, limbs + 1) and separations (n,) over the cycle of the motion."""
        angle, normal, s = self._cycle(gaits, motion)
        return clearances(
            self.setting.tree, self.capsules, self.limbs, angle, normal, s, self.curvature
        )

    def _cycle(self, gaits: GaitBatch, motion: Array) -> tuple[Array, Array, Array]:
        """Leg angles, the ground's normal and s at instants of a cycle (n, instants, ...)."""
        steps = motion.shape[1]
        every = max(1, steps // _CLOSE_SAMPLES)
        some = motion[:, ::every]
        turn = np.multiply.outer(
            np.arange(0, steps, every), 2 * np.pi / steps * (np.arange(gaits.sine.shape[1]) + 1)
        )
        angle = np.sin(turn) @ gaits.sine + np.cos(turn) @ gaits.cosine + gaits.offset[:, None]
        if self.setting.axis == ANY:
            return angle, some[:, :, 6:9], some[:, :, 9:12]
        return angle, some[:, :, :3], some[:, :, :3] * self.setting.parameters[1]
