"""What is computed of a sweep, in chunks on an executor, and how the rest is."""

from __future__ import annotations

import contextlib
import math
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Executor, Future, wait
from functools import partial
from typing import Any

import numpy as np

from rrrobot.checks import Array
from rrrobot.errors import OutputError, SweepError, SweepInterrupted
from rrrobot.studies.sweeps.grid import Plan
from rrrobot.studies.sweeps.progress import Tell
from rrrobot.studies.sweeps.store import NOT_COMPUTED, Layout, ResultsFile, curvature, pending
from rrrobot.studies.sweeps.variants import Variants, clearance

_STILL = 1e-9
"""Amplitude up to which an axis has no phase [rad]."""


class Job:
    """What is computed of a sweep, and how the rest is.

    Attributes:
        columns: results, flat (gaits,).
    """

    def __init__(
        self,
        plan: Plan,
        variants: Variants,
        run: dict[str, Any],
        layout: Layout,
        file: ResultsFile | None,
    ) -> None:
        self._plan, self._variants, self._run = plan, variants, run
        self._layout, self._file = layout, file
        self.columns = layout.empty()
        if file is not None:
            file.read_into(self.columns)

    @property
    def done(self) -> int:
        """Gaits whose results are in the columns, and in the file if there is one."""
        return int(np.count_nonzero(self.columns["status"] != NOT_COMPUTED))

    def compute(self, executor: Executor, chunk: int, tell: Tell, at_once: int) -> None:
        """Run what is missing in chunks, at most `at_once` of them at a time."""
        size = math.prod(self._plan.gait_sizes.values())
        running: dict[Future[Array], tuple[int, Array]] = {}
        try:
            for first, last in pending(self.columns["status"], size, chunk):
                engine, setting, robot = self._variants.at(first // size)
                gaits, yaw = self._plan.gaits(first % size, (last - 1) % size + 1)
                more: dict[str, Any] = {} if yaw is None else {"yaw_amplitude": yaw}
                future = executor.submit(partial(engine, setting, gaits, **self._run, **more))
                running[future] = first, clearance(robot, gaits)
                while len(running) >= at_once:
                    self._collect(running, tell)
            while running:
                self._collect(running, tell)
        except BaseException:
            self._stop(running)
            raise

    def interrupted(self) -> SweepInterrupted:
        """The error of a Ctrl-C."""
        kept = "the error's .dataset holds them; a file (store=, --out) would keep them."
        if self._file is not None:
            # A chunk may have come as far as the file.
            self._file.read_into(self.columns)
            kept = f"{str(self._file.path)!r} keeps them, and the same sweep goes on from there."
        return SweepInterrupted(
            f"the sweep was interrupted after {self.done} of {self._layout.size} gaits; {kept}",
            self._layout.dataset(self.columns),
        )

    def failed(self, error: Exception) -> SweepError:
        """The error of a store or a worker that failed."""
        if isinstance(error, BrokenExecutor):
            reason = "a process of the executor ended at once (killed, or out of memory)"
        else:
            reason = str(error).rstrip(".")
        kept = "the error's .dataset holds them"
        if self._file is not None and isinstance(error, BrokenExecutor):
            kept = f"{str(self._file.path)!r} keeps them, and the same sweep goes on from there"
        return SweepError(
            f"{reason}. The sweep stopped after {self.done} of {self._layout.size} gaits; {kept}.",
            self._layout.dataset(self.columns),
        )

    def _collect(self, running: dict[Future[Array], tuple[int, Array]], tell: Tell) -> None:
        """Wait for a chunk, and keep all that are finished."""
        for future in wait(running, return_when=FIRST_COMPLETED).done:
            first, height = running.pop(future)
            self._keep(first, future.result(), height)
        tell(self.done)

    def _stop(self, running: dict[Future[Array], tuple[int, Array]]) -> None:
        """Call off what waits, and keep what is finished or under way."""
        for future in wait([future for future in running if not future.cancel()]).done:
            if future.exception() is None:
                first, height = running[future]
                # What stopped the sweep may be the store.
                with contextlib.suppress(OutputError):
                    self._keep(first, future.result(), height)

    def _keep(self, first: int, result: Array, height: Array) -> None:
        from rrrobot.momentum.batch import LOADS, RESULT

        names = (*RESULT, *LOADS) if self._run.get("loads") else RESULT
        found = dict(zip(names, result.T, strict=True))
        found["clearance"] = height
        found["curvature"] = curvature(found["speed"], found["yaw_rate"])
        turn = found["yaw_phase"] - found["pitch_phase"] + np.pi
        swings = (found["pitch_amplitude"] > _STILL) & (found["yaw_amplitude"] > _STILL)
        turn = np.where(swings, -(turn % (2 * np.pi) - np.pi), np.nan)
        found["pitch_yaw_phase_difference"] = turn
        part = {name: found[name].astype(column.dtype) for name, column in self.columns.items()}
        for name, column in self.columns.items():
            column[first : first + len(result)] = part[name]
        if self._file is not None:
            self._file.write(first, part)
