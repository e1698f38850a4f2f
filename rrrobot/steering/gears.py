"""Inverse maps: (speed, curvature) -> gait, smooth and unique, in four directions of travel.

With both legs' offset at 0 (they point forwards) the robot travels along its x axis, and the phase
difference p steers it: half a turn is straight on. At an offset near pi/2 (they point up) it
travels sideways about twice as fast, and the offset steers. Each such family of gaits is a gear;
within it one number q steers and the amplitude sets the speed:

    speed = r (c_0(q) + c_1(q) r),   r = (amplitude / largest)^2,   curvature = yaw rate / speed.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq

from rrrobot.checks import Array
from rrrobot.errors import ModelError, ParameterError
from rrrobot.steering.motions import Motions

GEARS = ("forward", "backward", "left", "right")
"""Directions of travel in the body's axes: x, -x, y, -y."""
_N = 241
_R = np.linspace(0.01, 1.0, 298)
"""Squared shares of the amplitude at which it is known which curvatures are reached."""


class Drive(NamedTuple):
    """One gait of a gear and what it does when settled."""

    offset: float
    """of both legs [rad]"""
    amplitude: float
    """[rad]"""
    phase_difference: float
    """of leg 2 from leg 1 [rad]"""
    twist: Array
    """(u, v, yaw rate) along the mean body axes (3,)"""

    @property
    def speed(self) -> float:
        """[m/s]"""
        return float(np.hypot(self.twist[0], self.twist[1]))

    @property
    def course(self) -> float:
        """Direction of travel in the body's axes [rad]."""
        return float(np.arctan2(self.twist[1], self.twist[0]))


class Gear:
    """The gaits of one direction of travel, by speed and curvature.

    Args:
        motions: of `motions_of`.
        name: "forward", "backward", "left" or "right".

    Attributes:
        curvature: lowest and highest that are reached at any amplitude (2,) [1/m].
        brisk: lowest and highest at the largest amplitude; beyond these the robot creeps.

    Raises:
        ParameterError: another name.
        ModelError: the robot's gaits do not steer monotonically in this gear.

    Example:
        >>> import rrrobot as rr
        >>> from rrrobot.steering.gears import Gear
        >>> from rrrobot.steering.motions import motions_of
        >>> gear = Gear(motions_of(rr.FullModel(rr.Robot.from_parameters())), "forward")
        >>> drive = gear.drive(0.008, 4.0)
        >>> round(drive.speed, 6), round(float(drive.twist[2]), 6), gear.fastest(0.0) > 0.012
        (0.008, 0.032, True)
    """

    def __init__(self, motions: Motions, name: str) -> None:
        if name not in GEARS:
            raise ParameterError(f"gear is {name!r}: known are {', '.join(GEARS)}.")
        self.name = name
        self._largest = float(motions.amplitude.max())
        self._along = name in ("forward", "backward")
        q, low, high = (_by_phase if self._along else _by_offset)(motions, name)
        share = (float(motions.amplitude.min()) / self._largest) ** 2
        # twist = r (c0 + c1 r), exact at both amplitudes.
        c1 = (high - low / share) / (1.0 - share)
        self._c0, self._c1 = CubicSpline(q, high - c1), CubicSpline(q, c1)
        self._fixed = 0.0 if name == "forward" else np.pi
        if not self._along:
            self._fixed = _best_phase(motions, name)
        self._q = np.linspace(q[0], q[-1], _N)
        k = self._curvatures(1.0)
        self._q = self._q[_rising(k)]
        # At each amplitude the gaits reach other curvatures.
        self._ranges = np.array(
            [(r, bends.min(), bends.max()) for r in _R for bends in (self.curve(r)[0],)]
        )
        self.curvature = np.array((self._ranges[:, 1].min(), self._ranges[:, 2].max()))
        self.brisk = self._ranges[-1, 1:].copy()
        fastest = np.linalg.norm(motions.twist[:, :2], axis=1).max()
        if len(self._q) < 10 or self.fastest(0.0) < 0.02 * fastest:
            raise ModelError(f"the gaits of the gear {name!r} do not travel or steer this robot.")

    def twist(self, q: Array | float, r: float) -> Array:
        """Settled twist (..., 3) at the steering number q and the squared share r of amplitude."""
        return np.asarray(r * (self._c0(q) + self._c1(q) * r))

    def _curvatures(self, r: float) -> Array:
        t = self.twist(self._q, r)
        return np.asarray(t[:, 2] / np.maximum(np.hypot(t[:, 0], t[:, 1]), 1e-12))

    def _steered(self, curvature: float, r: float, k: Array, q: Array) -> float:
        """The q of a curvature at r, between nodes q where it is k, k rising."""
        i = int(np.clip(np.searchsorted(k, curvature), 1, len(k) - 1))
        if not k[i - 1] < curvature < k[i]:
            return float(np.interp(curvature, k, q))

        def miss(at: float) -> float:
            t = self.twist(at, r)
            return float(t[2] / np.hypot(t[0], t[1])) - curvature

        return float(brentq(miss, q[i - 1], q[i], xtol=1e-14))

    def fastest(self, curvature: float) -> float:
        """Highest speed at a curvature [m/s]; the boundary of the reachable set."""
        return self.drive(np.inf, curvature).speed

    def boundary(self, n: int = 101) -> tuple[Array, Array, Array]:
        """Curvatures (n,) [1/m] from the lowest to the highest, lowest and highest speeds [m/s].

        Between these lies all that the gear reaches: at the outermost curvatures, which only some
        amplitudes have, not down to zero.
        """
        curvature = np.linspace(self.curvature[0], self.curvature[1], n)
        slow, fast = (np.array([self.drive(v, k).speed for k in curvature]) for v in (0.0, np.inf))
        return curvature, slow, fast

    def curve(self, r: float) -> tuple[Array, Array]:
        """Curvatures (n,) [1/m] and speeds (n,) [m/s] of one squared share r of the amplitude."""
        bends = self._curvatures(r)
        good = _rising(bends)
        return bends[good], np.linalg.norm(self.twist(self._q[good], r)[:, :2], axis=1)

    def reaches(self, speed: float, curvature: float) -> bool:
        """Whether a gait of the gear has a speed [m/s] and a curvature [1/m]."""
        low, high = self.curvature
        found = self.drive(speed, curvature)
        return bool(low <= curvature <= high and abs(found.speed - speed) <= 1e-9 + 1e-6 * speed)

    def drive(self, speed: float, curvature: float) -> Drive:
        """The gait of a speed and a curvature; the nearest where they are out of reach.

        Out of reach the curvature is kept before the speed, for the path is what matters.

        Args:
            speed: [m/s], zero or more.
            curvature: yaw rate / speed [1/m], positive to the left.
        """
        bend = float(np.clip(curvature, *self.curvature))
        steers = _R[(self._ranges[:, 1] <= bend) & (bend <= self._ranges[:, 2])]
        least, most = (1e-6 if steers[0] == _R[0] else steers[0]), steers[-1]
        r = most
        for _ in range(20):
            # At small amplitudes the outermost gaits turn back.
            k = self._curvatures(r)
            good = _rising(k)
            order = 1 if k[good][-1] > k[good][0] else -1
            q = self._steered(bend, r, k[good][::order], self._q[good][::order])
            c0, c1 = self._c0(q), self._c1(q)
            # |twist| at r, solved for the speed by Newton's method.
            size = float(np.hypot(*(r * (c0 + c1 * r))[:2]))
            slope = float(((c0 + c1 * r)[:2] @ (c0 + 2 * c1 * r)[:2]) * r / max(size, 1e-12))
            wanted = r + (speed - size) / max(slope, 1e-12) if np.isfinite(speed) else most
            wanted = float(np.clip(wanted, least, most))
            if abs(wanted - r) < 1e-12:
                break
            r = wanted
        offset, phase = (self._fixed, q) if self._along else (q, self._fixed)
        return Drive(offset, self._largest * float(np.sqrt(r)), phase, self.twist(q, r))


def grid(motions: Motions) -> tuple[Array, Array, list[Array]]:
    """A map's offsets, phases, and twists (offsets, phases, 3) at both amplitudes, rising."""
    offsets, phases = np.unique(motions.offset), np.unique(motions.phase_difference)
    out = []
    for amplitude in (motions.amplitude.min(), motions.amplitude.max()):
        table = np.full((len(offsets), len(phases), 3), np.nan)
        rows = np.isclose(motions.amplitude, amplitude)
        i = np.searchsorted(offsets, motions.offset[rows])
        j = np.searchsorted(phases, motions.phase_difference[rows])
        table[i, j] = motions.twist[rows]
        out.append(_filled(table, phases))
    return offsets, phases, out


def _filled(table: Array, phases: Array) -> Array:
    """Missing motions by interpolation along the phase."""
    out = table.copy()
    for i in range(out.shape[0]):
        for a in range(3):
            known = np.isfinite(out[i, :, a])
            out[i, ~known, a] = np.interp(
                phases[~known], phases[known], out[i, known, a], period=2 * np.pi
            )
    return out


def _by_phase(motions: Motions, name: str) -> tuple[Array, Array, Array]:
    _, phases, (low, high) = grid(motions)
    row = 0 if name == "forward" else -1
    keep = (phases > 0.3 * np.pi) & (phases < 1.7 * np.pi)
    return phases[keep], low[row][keep], high[row][keep]


def _best_phase(motions: Motions, name: str) -> float:
    offsets, phases, (_, high) = grid(motions)
    middle = high[len(offsets) // 2, :, 1]
    return float(phases[middle.argmax() if name == "left" else middle.argmin()])


def _by_offset(motions: Motions, name: str) -> tuple[Array, Array, Array]:
    offsets, phases, (low, high) = grid(motions)
    column = int(np.argmin(np.abs(phases - _best_phase(motions, name))))
    return offsets, low[:, column], high[:, column]


def _rising(k: Array) -> slice:
    """The longest stretch about the middle in which k is monotonic."""
    middle, step = len(k) // 2, np.sign(np.diff(k))
    first = last = middle
    while first > 0 and step[first - 1] == step[middle]:
        first -= 1
    while last < len(k) - 1 and step[last] == step[middle]:
        last += 1
    return slice(first, last + 1)
