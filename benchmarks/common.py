"""What the measurements share: the gaits, the true answer, errors, clocks, the machine's record."""

from __future__ import annotations

import json
import os
import platform
import statistics
import subprocess
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

import rrrobot as rr
from rrrobot.drive.gaits import GaitBatch
from rrrobot.momentum.batch import RESULT, Setting, lower, steady_states

Array = NDArray[np.float64]

ROOT = Path(__file__).resolve().parent.parent
RESULTS = ROOT / "benchmarks" / "results"

AMPLITUDE = 0.3
"""Of both legs [rad]."""
OMEGA = 8.0
"""Angular frequency of the legs [rad/s]."""
PERIOD = 2 * np.pi / OMEGA
CYCLES = 38
"""Simulated cycles: 29.85 s."""
COUNTED = 19
"""Cycles at the end that count: from 14.9 s on."""
STEPS = 10
"""Engine's steps in a cycle, unless something else is measured."""
TRUE_STEPS = 40
"""And those of the true answer."""
KAPPA = 0.01
"""Damping [N m s/rad]."""
MIN_SPEED = 2e-4
MIN_YAW_RATE = 1e-3
"""Relative errors count where the true speed [m/s] or yaw rate [rad/s] is greater."""


class Plane(NamedTuple):
    """Gaits: offset of both legs, and the phase by which leg 2 leads leg 1, each (n,) [rad]."""

    offset: Array
    phase: Array

    def gaits(self) -> GaitBatch:
        """As the engine takes them."""
        n, zero = self.offset.size, np.zeros_like(self.phase)
        return GaitBatch.sinusoidal(
            np.column_stack((self.offset, self.offset)),
            np.full((n, 2), AMPLITUDE),
            np.column_stack((zero, self.phase)),
            np.full(n, OMEGA),
        )

    def gait(self, index: int) -> rr.SinusoidalGait:
        """One of them, as the library takes it."""
        return rr.SinusoidalGait(
            offset=(self.offset[index],) * 2,
            amplitude=AMPLITUDE,
            angular_frequency=OMEGA,
            phase=(0.0, self.phase[index]),
        )

    def take(self, indices: Any) -> Plane:
        """Some of them."""
        return Plane(self.offset[indices], self.phase[indices])


def plane(rows: int, columns: int) -> Plane:
    """Offsets 0..pi by phase differences 0..2 pi, both ends included."""
    axes = np.linspace(0.0, np.pi, rows), np.linspace(0.0, 2 * np.pi, columns)
    offset, phase = np.meshgrid(*axes, indexing="ij")
    return Plane(offset.ravel(), phase.ravel())


PAPER_GAITS = Plane(np.array([np.pi / 2, np.pi / 4]), np.array([np.pi / 2, np.pi / 2]))
"""The lateral gait and the circular one."""


class Motion(NamedTuple):
    """Speed [m/s] and yaw rate [rad/s] of gaits, each (n,)."""

    speed: Array
    yaw_rate: Array


def full_model(damping: rr.drive.Damping | float = KAPPA) -> rr.FullModel:
    """RRRobot of Table 2, rolling."""
    return rr.FullModel(rr.Robot.from_parameters(), damping=damping)


def engine(
    setting: Setting,
    gaits: GaitBatch,
    *,
    cycles: int = CYCLES,
    counted: int = COUNTED,
    steps: int = STEPS,
    threads: int = 1,
    chunk: int = 0,
) -> Array:
    """The engine's steady states (n, len(RESULT)), on threads over chunks of gaits."""

    def part(first: int) -> Array:
        some = gaits.rows(slice(first, first + size))
        return steady_states(setting, some, cycles=cycles, counted=counted, steps_per_cycle=steps)

    n = gaits.n
    # A multiple of the engine's sixteen lanes.
    size = chunk or 16 * max(1, -(-n // (16 * 4 * threads)))
    if threads == 1 and not chunk:
        size = n
    starts = range(0, n, size)
    if threads == 1:
        return np.concatenate([part(first) for first in starts])
    with ThreadPoolExecutor(threads) as pool:
        return np.concatenate(list(pool.map(part, starts)))


def engine_motion(found: Array) -> Motion:
    """Speed and yaw rate of the engine's steady states."""
    return Motion(found[:, RESULT.index("speed")], found[:, RESULT.index("yaw_rate")])


def true_motion(gaits: GaitBatch, damping: rr.drive.Damping | float = KAPPA) -> Motion:
    """The true answer: the engine with four times its usual steps."""
    return engine_motion(engine(lower(full_model(damping)), gaits, steps=TRUE_STEPS))


def kkt_motion(gait: rr.SinusoidalGait, damping: rr.drive.Damping | float = KAPPA) -> Motion:
    """Speed and yaw rate of one gait by the full model's KKT system, tolerances 1e-12."""
    t = rr.simulate(
        full_model(damping), gait, duration=CYCLES * PERIOD, sample_interval=PERIOD / 96,
        rtol=1e-12, atol=1e-12,
    )  # fmt: skip
    s = t.steady_state(after=(CYCLES - COUNTED) * PERIOD)
    return Motion(np.array([s.speed]), np.array([s.yaw_rate]))


def motion_of_means(means: Array) -> Motion:
    """Speed and yaw rate of cycle means of (x, y, yaw), shape (cycles, n, 3)."""
    steps = np.diff(means, axis=0) / PERIOD
    return Motion(np.hypot(steps[..., 0], steps[..., 1]).mean(axis=0), steps[..., 2].mean(axis=0))


def errors(found: Motion, true: Motion) -> dict[str, float | None]:
    """Median and worst relative error of speed and yaw rate, where the true ones are not small.

    None where no gait counts.
    """
    result: dict[str, float | None] = {"failed": int(np.sum(~np.isfinite(found.speed)))}
    for name, least in (("speed", MIN_SPEED), ("yaw_rate", MIN_YAW_RATE)):
        have, want = getattr(found, name), getattr(true, name)
        counts = np.abs(want) > least
        relative = np.abs(have[counts] / want[counts] - 1)
        result[f"{name}_counted"] = int(counts.sum())
        result[f"{name}_median"] = float(np.median(relative)) if relative.size else None
        result[f"{name}_worst"] = float(np.max(relative)) if relative.size else None
    return result


def impulsive_rates(plane_: Plane) -> Array:
    """Body's angular velocity at the impulsive start of each gait, upright (n, 3) [rad/s]."""
    model = full_model()
    pose = model.make_pose(np.zeros(3), np.zeros(2))
    starts = (plane_.gait(i)(0.0) for i in range(plane_.offset.size))
    return np.array([model.impulsive_start(pose, leg.angle, leg.rate) for leg in starts])


class Timing(NamedTuple):
    """Seconds on the wall clock, and of processor time over all threads."""

    wall: float
    core: float


def clocked(function: Callable[[], object]) -> Timing:
    """Time of one call."""
    wall, core = time.perf_counter(), time.process_time()
    function()
    return Timing(time.perf_counter() - wall, time.process_time() - core)


def median(timings: list[Timing]) -> Timing:
    """Median of both clocks."""
    return Timing(*(statistics.median(part) for part in zip(*timings, strict=True)))


def repeated(function: Callable[[], object], repeats: int) -> list[Timing]:
    """Times of calls after one that does not count."""
    function()
    return [clocked(function) for _ in range(repeats)]


def _cpu_name() -> str:
    try:
        for line in Path("/proc/cpuinfo").read_text().splitlines():
            if line.startswith("model name"):
                return line.split(":", 1)[1].strip()
    except OSError:
        pass
    if platform.system() == "Darwin":
        command = ["sysctl", "-n", "machdep.cpu.brand_string"]
        return subprocess.run(command, capture_output=True, text=True).stdout.strip()
    return platform.processor() or platform.machine()


def _versions(*packages: str) -> dict[str, str]:
    found = {"python": platform.python_version()}
    for name in ("rrrobot", "numpy", "numba", "pin", *packages):
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "not installed"
    return found


def _busy() -> float | None:
    """Seconds in which any core did something, since the machine was started; None if unknown."""
    try:
        user, nice, system, _, _, irq, softirq, steal = map(
            int, Path("/proc/stat").read_text().split("\n", 1)[0].split()[1:9]
        )
    except (OSError, ValueError):
        return None
    return (user + nice + system + irq + softirq + steal) / os.sysconf("SC_CLK_TCK")


def _own() -> float:
    """Processor time of this process and of its finished children [s]."""
    return sum(os.times()[:4])


@contextmanager
def recorded(name: str, folder: Path, *packages: str) -> Iterator[dict[str, Any]]:
    """A record to fill, written to the folder as JSON when the measurements have succeeded.

    It holds date, versions, processor, load averages and how much of the cores other processes
    took meanwhile.
    """
    load, start, busy, own = os.getloadavg(), time.perf_counter(), _busy(), _own()
    record: dict[str, Any] = {"results": {}}
    yield record["results"]
    seconds, after, own = time.perf_counter() - start, _busy(), _own() - own
    others = None if busy is None or after is None else max(0.0, (after - busy - own) / seconds)
    record["machine"] = {
        "date": datetime.now(UTC).date().isoformat(),
        "processor": _cpu_name(),
        "cores": os.cpu_count(),
        "system": platform.system(),
        "load_average_before": [round(x, 2) for x in load],
        "load_average_after": [round(x, 2) for x in os.getloadavg()],
        "cores_taken_by_others": None if others is None else round(others, 2),
        "minutes": round(seconds / 60, 1),
        "versions": _versions(*packages),
    }
    folder.mkdir(exist_ok=True, parents=True)
    (folder / f"{name}.json").write_text(json.dumps(record, indent=1) + "\n")
