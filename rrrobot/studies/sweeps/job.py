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
from rrrobot.progress import Tell
from rrrobot.results import NOT_COMPUTED, completed
from rrrobot.studies.sweeps.grid import Plan
from rrrobot.studies.sweeps.store import Layout, ResultsFile, pending
from rrrobot.studies.sweeps.variants import Variants


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

    def compute(self, executor: Executor, chunk: int, tell: Tell | None, at_once: int) -> None:
        """Run what is missing in chunks, at most `at_once` of them at a time."""
        size = math.prod(self._plan.gait_sizes.values())
        running: dict[Future[Array], int] = {}
        if tell is not None:
            tell(self.done)
        try:
            for first, last in pending(self.columns["status"], size, chunk):
                engine, setting = self._variants.at(first // size)
                gaits, yaw = self._plan.gaits(first % size, (last - 1) % size + 1)
                more: dict[str, Any] = {} if yaw is None else {"yaw": yaw}
                tilt = self._plan.starts(first % size, (last - 1) % size + 1)
                if tilt is not None:
                    more["tilt"] = tilt
                future = executor.submit(partial(engine, setting, gaits, **self._run, **more))
                running[future] = first
                while len(running) >= at_once:
                    self._collect(running, tell)
            while running:
                self._collect(running, tell)
        except BaseException:
            self._stop(running)
            raise

    def interrupted(self) -> SweepInterrupted:
        """The error of a Ctrl-C."""
        kept = "the error's .dataset holds them; a file (store=) would keep them."
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

    def _collect(self, running: dict[Future[Array], int], tell: Tell | None) -> None:
        """Wait for a chunk, and keep all that are finished."""
        for future in wait(running, return_when=FIRST_COMPLETED).done:
            self._keep(running.pop(future), future.result())
        if tell is not None:
            tell(self.done)

    def _stop(self, running: dict[Future[Array], int]) -> None:
        """Call off what waits, and keep what is finished or under way."""
        for future in wait([future for future in running if not future.cancel()]).done:
            if future.exception() is None:
                # What stopped the sweep may be the store.
                with contextlib.suppress(OutputError):
                    self._keep(running[future], future.result())

    def _keep(self, first: int, result: Array) -> None:
        from rrrobot.momentum.batch import LOADS, RESULT

        loads = bool(self._run.get("loads"))
        names = (*RESULT, *LOADS) if loads else RESULT
        found = completed(dict(zip(names, result.T, strict=True)), loads=loads)
        part = {name: found[name].astype(column.dtype) for name, column in self.columns.items()}
        for name, column in self.columns.items():
            column[first : first + len(result)] = part[name]
        if self._file is not None:
            self._file.write(first, part)
