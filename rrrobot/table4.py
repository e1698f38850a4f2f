"""Table 4: how far the simplified models' travel and curvature are from the full model's.

Over a plane of leg offset and phase difference every model is simulated, and the ratios of speed
and curvature to the full model's are collected where the full model really travels and turns.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable
from concurrent.futures import Executor, ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from rrrobot.checks import vector
from rrrobot.compare import MODELS, compare
from rrrobot.errors import OutputError, ParameterError, SimulationError
from rrrobot.files import check_writable
from rrrobot.gaits import SinusoidalGait
from rrrobot.robot import Robot
from rrrobot.simulate import versions

PAPER = {
    "pivoting": {"speed": 1.01, "curvature": 10.0},
    "decoupled": {"speed": 1.25, "curvature": 0.9},
}
"""Table 4 as the paper prints it: over- and underprediction in its worst cases."""

MIN_SPEED = 1e-3
MIN_YAW_RATE = 2e-3
"""Ratios count where the full model moves at least this fast [m/s] and turns this fast [rad/s]."""


class Spread(NamedTuple):
    """Ratios of a model to the full model over the plane."""

    lowest: float
    median: float
    highest: float
    points: int


@dataclass(frozen=True, kw_only=True)
class Table4:
    """Ratios of travel and of curvature, by model, and the points behind them.

    Attributes:
        speed: model -> Spread of speed ratios.
        curvature: model -> Spread of curvature ratios.
        points: one dict for each gait: offset, phase_difference [rad] and, by model, speed,
            yaw_rate and curvature; or `stopped`, why a simulation ended early.

    Example:
        >>> import rrrobot as rr
        >>> spread = rr.table4.Spread(lowest=0.98, median=1.05, highest=1.15, points=22)
        >>> rr.Table4(speed={"pivoting": spread}, curvature={}, points=[]).speed["pivoting"].median
        1.05
    """

    speed: dict[str, Spread]
    curvature: dict[str, Spread]
    points: list[dict[str, Any]]


def table_4(
    robot: Robot,
    *,
    offsets: ArrayLike,
    phase_differences: ArrayLike,
    amplitude: float = 0.3,
    angular_frequency: float = 8.0,
    duration: float = 30.0,
    store: str | Path | None = None,
    executor: Executor | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Table4:
    """Compare the models over a plane of gaits.

    Args:
        robot: RRRobot, or another with two legs and a sphere about its root link's origin.
        offsets: of both legs (m,) [rad].
        phase_differences: by which leg 2 leads leg 1 (n,) [rad].
        amplitude: of both legs [rad].
        angular_frequency: [rad/s].
        duration: of each simulation [s].
        store: a file of JSON lines that takes each point as it is finished; points that it
            already holds are not simulated again, so an interrupted study goes on.
        executor: runs the points; two worker processes if None.
        progress: called with (points done, points in all).

    Raises:
        OutputError: the store belongs to another study, or cannot be written.

    Example:
        >>> import rrrobot as rr
        >>> from concurrent.futures import ThreadPoolExecutor
        >>> robot = rr.Robot.from_parameters()
        >>> with ThreadPoolExecutor(1) as pool:
        ...     table = rr.table_4(robot, offsets=[1.57], phase_differences=[1.57],
        ...                        duration=12.0, executor=pool)
        >>> table.speed["pivoting"].points
        1
    """
    rows = vector("offsets", offsets, np.size(offsets), "rad")
    columns = vector("phase_differences", phase_differences, np.size(phase_differences), "rad")
    if not rows.size or not columns.size:
        raise ParameterError("offsets and phase_differences must each hold at least one angle.")
    settings = {
        "study": "table 4",
        "robot": robot.to_dict(),
        "amplitude": amplitude,
        "angular_frequency": angular_frequency,
        "duration": duration,
        "versions": versions(),
    }
    gaits = {(float(o), float(p)) for o in rows for p in columns}
    done = {} if store is None else _read(Path(store), settings)
    todo = sorted(gaits - done.keys())
    pool = executor or ProcessPoolExecutor(2, mp_context=get_context("spawn"))
    try:
        jobs = [
            pool.submit(_point, robot, o, p, amplitude, angular_frequency, duration)
            for o, p in todo
        ]
        for job in as_completed(jobs):
            point = job.result()
            done[point["offset"], point["phase_difference"]] = point
            if store is not None:
                with Path(store).open("a") as lines:
                    lines.write(json.dumps(point) + "\n")
            if progress is not None:
                progress(len(gaits & done.keys()), len(gaits))
    finally:
        if executor is None:
            pool.shutdown(cancel_futures=True)
    points = [done[key] for key in sorted(gaits)]
    return Table4(
        speed={m: _spread(points, m, "speed") for m in MODELS[1:]},
        curvature={m: _spread(points, m, "curvature") for m in MODELS[1:]},
        points=points,
    )


def _point(
    robot: Robot, offset: float, phase: float, amplitude: float, omega: float, duration: float
) -> dict[str, Any]:
    """One gait, simulated by every model."""
    gait = SinusoidalGait(
        offset=(offset, offset), amplitude=amplitude, angular_frequency=omega, phase=(0.0, phase)
    )
    point: dict[str, Any] = {"offset": offset, "phase_difference": phase}
    try:
        found = compare(robot, gait, duration, sample_interval=0.02)
    except SimulationError as error:
        return point | {"stopped": str(error).split(".")[0]}
    for name, state in found.states.items():
        point[name] = {"speed": state.speed, "yaw_rate": state.yaw_rate}
    return point | {"yaw_amplitude_factor": found.yaw_amplitude_factor}


def _spread(points: Iterable[dict[str, Any]], model: str, quantity: str) -> Spread:
    ratios = []
    for point in points:
        if "stopped" in point or model not in point:
            continue
        full, ours = point["full"], point[model]
        if full["speed"] < MIN_SPEED or ours["speed"] < 1e-9:
            continue
        ratio = ours["speed"] / full["speed"]
        if quantity == "curvature":
            if abs(full["yaw_rate"]) < MIN_YAW_RATE:
                continue
            ratio = ours["yaw_rate"] / full["yaw_rate"] / ratio
        ratios.append(ratio)
    if not ratios:
        return Spread(float("nan"), float("nan"), float("nan"), 0)
    return Spread(min(ratios), float(np.median(ratios)), max(ratios), len(ratios))


def _read(store: Path, settings: dict[str, Any]) -> dict[tuple[float, float], dict[str, Any]]:
    """Finished points of a store; a new store gets the settings as its first line."""
    if not store.exists():
        check_writable(store)
        store.write_text(json.dumps(settings) + "\n")
        return {}
    try:
        first, *lines = store.read_text().splitlines()
        head = json.loads(first)
        # A killed process may leave half a last line; that point is simulated again.
        points = [json.loads(line) for line in lines if line.endswith("}")]
    except (OSError, ValueError) as error:
        raise OutputError(f"{str(store)!r} is not a study's store: {error}.") from None
    differ = sorted(k for k in settings if head.get(k) != settings[k])
    if differ:
        raise OutputError(
            f"{str(store)!r} holds another study: it differs in {', '.join(differ)}. Name another "
            "file, or delete it."
        )
    return {(p["offset"], p["phase_difference"]): p for p in points}
