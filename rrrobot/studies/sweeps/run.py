"""Sweeps: grids or lists of gaits, and of robots -> one labelled dataset of steady states.

The gaits phi_k(t) = offset_k + winding_k omega t + amplitude_k sin(omega t + phase_k) of a sweep,
or those of a list, are numbered. Chunks of them are made, simulated by the momentum engine on
threads or on any executor, and stored. A gait's result depends on nothing but the gait, so neither
the chunks nor who computes them change a bit of it.
"""

from __future__ import annotations

import json
import math
import os
from collections.abc import Mapping, Sequence
from concurrent.futures import BrokenExecutor, Executor, ThreadPoolExecutor
from contextlib import ExitStack
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

from numpy.typing import ArrayLike

from rrrobot.checks import whole
from rrrobot.drive.gaits import Gait
from rrrobot.errors import OutputError, ParameterError
from rrrobot.models.base import Model
from rrrobot.models.recombined import DecoupledModels
from rrrobot.progress import Progress, progress_of
from rrrobot.robot.parameters import RRRobotParameters
from rrrobot.simulation.evaluate import versions
from rrrobot.studies.sweeps.counts import enough_cycles, run_settings
from rrrobot.studies.sweeps.grid import Grid, Plan
from rrrobot.studies.sweeps.job import Job
from rrrobot.studies.sweeps.passing import warn_of_gaits
from rrrobot.studies.sweeps.store import Layout, ResultsFile
from rrrobot.studies.sweeps.variants import Variants, engine_of

if TYPE_CHECKING:
    import xarray as xr

AMPLITUDE, ANGULAR_FREQUENCY = 0.3, 8.0
"""The paper's, where a sweep names no other [rad], [rad/s]."""
LARGEST = 50_000_000
"""Most gaits of a sweep; their results take 7 GB."""
_CHUNK = 4096
_LANES = 16
"""Gaits that the engine takes at once: chunks are multiples of it."""
_IN_FLIGHT = 32
"""Chunks that an executor is given at once, so that a long queue takes no memory."""


def sweep(
    model: Model,
    *,
    offset: Grid | None = None,
    phase_difference: Grid | None = None,
    phase: Grid | None = None,
    amplitude: Grid | None = None,
    angular_frequency: Grid | None = None,
    winding: Grid | None = None,
    start_roll: Grid | None = None,
    start_pitch: Grid | None = None,
    yaw_amplitude: float | xr.DataArray | None = None,
    points: Mapping[str, ArrayLike] | Sequence[Gait] | None = None,
    parameters: Mapping[str, ArrayLike] | None = None,
    cycles: int | None = None,
    counted: int | None = None,
    steps_per_cycle: int | None = None,
    store: str | Path | None = None,
    resume: bool = True,
    chunk: int | None = None,
    executor: Executor | None = None,
    threads: int | None = None,
    loads: bool = False,
    settle: str = "cycles",
    progress: Progress = None,
) -> xr.Dataset:
    """Steady states of a model under all gaits of a grid, or under a list of gaits.

    Each of the first six arguments is a number, a grid for all legs (a list or an array), or one
    number or grid for each leg (a tuple, or a mapping from joint names). Every grid becomes a
    dimension of the result, every number a coordinate.

    Args:
        model: any of the five models, or `DecoupledModels`, on a spherical shell and level
            ground.
        offset: centre of the legs' swing [rad].
        phase_difference: by which leg 2 leads leg 1, on robots with two legs [rad]; pi/2 unless
            given.
        phase: of each leg instead, on any robot [rad]; 0 unless given.
        amplitude: of the swing [rad]; 0.3 unless given.
        angular_frequency: of all legs [rad/s]; 8 unless given.
        winding: whole turns of the legs in a period; 0 unless given. At amplitude 0 they go round
            at a constant rate.
        start_roll, start_pitch: tilt of the body at the start, before the impulse [rad]; 0 unless
            given. What a gait comes to may depend on it where there are several attractors.
        yaw_amplitude: of the legs in the yaw model alone of `DecoupledModels`, the paper's Fig 20
            [rad]: a number, or a DataArray over some of the gaits' dimensions, such as
            `rr.studies.amplitude_modulation` gives; where it is NaN, as the other models'.
        points: gaits instead of a grid: periodic ones of any kind, see `Gait.harmonics`; or a
            mapping from the names above to arrays (n,) or, one column a leg, (n, legs). What it
            does not name may still be a grid.
        parameters: grids of the robot's parameters by name, for each of whose values the model is
            made anew: those of `RRRobotParameters`, for a robot that `Robot.from_parameters` made;
            of any other robot those that `robot.varied` takes, such as "LINK.mass".
        cycles: simulated, from an impulsive start. Unless given, 38, which last 30 s at 8 rad/s,
            and more where the slowest mode about rest, with the legs held at the ends or the
            middle of their offsets, is not down to 0.1 % when the counted cycles begin; 10,000 at
            most.
        counted: cycles at the end over which means are taken. Unless given, 18, or with `cycles`
            those in the second half, as `Trajectory.steady_state` has it.
        steps_per_cycle: of the fixed-step DOP853; 10 give the speed of sinusoidal gaits to 3e-7 on
            RRRobot. Unless given, 10 for those, and 8 more for each harmonic or turn of others.
        store: a netCDF file (.nc) that takes each chunk as it is finished. If it is there, what
            it holds of this sweep is not computed again.
        resume: False: replace that file.
        chunk: gaits computed at once; by default enough to keep every thread busy, at most 4096.
        executor: runs the chunks: threads, processes, or a Dask cluster's
            `Client.get_executor()`.
        threads: of our own, without an executor; one for each usable core unless given.
        loads: whether to have `peak_torque`, `rms_torque`, `power` of the motors and the
            `friction` that the contact needs too, all of the last cycle. NaN where they
            mean nothing: all for `DecoupledModels`, friction for pivoted models. 10 steps a cycle
            give torques and friction to 1e-3 at worst on RRRobot (2e-5 in the middle), 20 to 1e-6.
        settle: "cycles": simulate `cycles` of each gait, as the paper does, and take what they
            have come to; "orbit": find its limit cycle (see `limit_cycle`), which needs no cycles
            and leaves no transient. A gait whose orbit of one period does not hold has the status
            6, one without any 7. `variation` is then the orbit's residual, and `yaw_mean` that of
            a cycle that starts with yaw 0. Of several cycles it is the one that Newton's method
            finds from rest, not always that which an upright start comes to.
        progress: see `rrrobot.progress`; in gaits.

    Returns:
        a Dataset with the variables of `rrrobot.results.COLUMNS` and `status`, which says why a
        gait was stopped (its results are NaN). Each variable's attributes hold its unit, the
        dataset's the model, the robot and the versions as JSON.

    Raises:
        ParameterError: a grid that is empty or not finite, a wrong number of legs, other numbers
            out of range.
        GaitError: points that are no periodic gaits, or turns that are not whole.
        ModelError: a model that the engine does not know.
        OutputError: the store is another sweep's, or cannot be written.
        SweepInterrupted: Ctrl-C.
        SweepError: the store was replaced or its disk failed, or a process of the executor was
            killed; its `dataset` holds what was computed.

    Warns:
        UnsettledWarning: gaits change by more than 5 % from cycle to cycle, `variation`.
        GroundClearanceWarning: a gait swings a leg through the ground, `clearance` <= 0.
        LimitWarning: gaits pass limits of the robot's file: position, rate and, with loads, effort.

    Example:
        >>> import numpy as np, rrrobot as rr
        >>> model = rr.FullModel(rr.Robot.from_parameters())
        >>> ds = rr.sweep(model, offset=[np.pi / 4, np.pi / 2], phase_difference=[np.pi / 2])
        >>> dict(ds.sizes), round(float(ds.speed[1, 0]), 6)
        ({'offset': 2, 'phase_difference': 1}, 0.009656)
    """
    engine_of(model, settle)
    if not isinstance(loads, bool):
        raise ParameterError(f"loads is {loads!r}: it must be True or False.")
    threads = _cores() if threads is None else whole("threads", threads, at_least=1)
    plan = Plan(model.robot.legs)
    plan.add_parameters(parameters or {})
    if points is not None:
        plan.add_points(points)
    plan.add("offset", offset)
    plan.add_phases(phase_difference, phase)
    plan.add("amplitude", amplitude, AMPLITUDE)
    plan.add("angular_frequency", angular_frequency, ANGULAR_FREQUENCY)
    plan.add_winding(winding)
    plan.add_start(model, start_roll=start_roll, start_pitch=start_pitch)
    if settle == "orbit" and plan.starts(0, 1) is not None:
        raise ParameterError("a limit cycle does not depend on its start: leave out start_roll and "
                             "start_pitch, or settle by cycles.")  # fmt: skip
    if yaw_amplitude is not None:
        if not isinstance(model, DecoupledModels):
            raise ParameterError("yaw_amplitude is for DecoupledModels: leave it out.")
        plan.add_yaw_amplitude(yaw_amplitude)
    variants = Variants(model, {name: plan.coords[name][1] for name in parameters or {}}, settle)
    steps = plan.steps if steps_per_cycle is None else steps_per_cycle
    run = run_settings(cycles, counted, steps) | {"loads": loads}
    if settle == "orbit":
        run = {key: run[key] for key in ("steps_per_cycle", "loads")}
    elif cycles is None:
        run["cycles"] = enough_cycles(
            variants.ends(), plan.offsets, plan.highest_frequency, run["counted"]
        )
    layout = Layout(plan.sizes, plan.coords, _attrs(model, variants.base, run) | {"settle": settle})
    if layout.size > LARGEST:
        raise ParameterError(
            f"the sweep has {layout.size} gaits, the limit is {LARGEST}: make the grids coarser, "
            "or sweep in parts."
        )
    if chunk is None:
        chunk = min(_CHUNK, _LANES * math.ceil(layout.size / (4 * threads * _LANES)))
    chunk = whole("chunk", chunk, at_least=1)
    with ExitStack() as stack:
        file = None
        if store is not None:
            file = stack.enter_context(ResultsFile(store, layout, resume=resume))
        job = Job(plan, variants, run, layout, file)
        what = f"{model.name} model"
        try:
            with progress_of(progress, what, layout.size, "gaits", job.done) as tell:
                if executor is None:
                    with ThreadPoolExecutor(threads) as pool:
                        job.compute(pool, chunk, tell, threads + 1)
                else:
                    job.compute(executor, chunk, tell, _IN_FLIGHT)
        except KeyboardInterrupt:
            raise job.interrupted() from None
        except (BrokenExecutor, OutputError) as error:
            raise job.failed(error) from error
    warn_of_gaits(model.robot, plan, job.columns)
    return layout.dataset(job.columns)


def _attrs(model: Model, base: RRRobotParameters | None, run: dict[str, int]) -> dict[str, Any]:
    """What a dataset says of itself."""
    from llvmlite import binding  # type: ignore[import-untyped, unused-ignore]

    from rrrobot.momentum.cache import engine_hash

    here = {"cpu": binding.get_host_cpu_name(), "engine": engine_hash()}
    used = versions() | {name: version(name) for name in ("numba", "xarray")}
    return {
        "title": f"steady states of gaits: {model.name} model of {model.robot.name}",
        "Conventions": "CF-1.8",
        "model": json.dumps(model.to_dict()),
        "parameters": json.dumps(None if base is None else base.to_dict()),
        "robot": json.dumps(model.robot.to_dict()),
        **{name: int(value) for name, value in run.items()},
        "versions": json.dumps(used | here),
    }


def _cores() -> int:
    usable = getattr(os, "sched_getaffinity", None)
    return len(usable(0)) if usable else os.cpu_count() or 1
