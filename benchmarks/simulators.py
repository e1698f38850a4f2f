"""The paper's two gaits by other simulators, each in an environment of its own.

Run with `python -m benchmarks.simulators`; writes benchmarks/results/simulators.json. Drake, Exudyn
and Jiminy are installed in `.venv-peers/` when they are first needed, since what they require need
not agree with Pinocchio. `--only drake` measures one of them and writes nothing.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

import rrrobot as rr
from benchmarks.common import (
    AMPLITUDE,
    COUNTED,
    CYCLES,
    KAPPA,
    OMEGA,
    PAPER_GAITS,
    PERIOD,
    RESULTS,
    ROOT,
    STEPS,
    Motion,
    Timing,
    engine,
    engine_motion,
    full_model,
    impulsive_rates,
    kkt_motion,
    median,
    motion_of_means,
    plane,
    recorded,
    repeated,
)
from benchmarks.peer_job import Job, as_json
from benchmarks.simulator_cases import CASES, PEERS, Case, Peer

HOME = ROOT / ".venv-peers"


def job(case: Case, gait: int) -> Job:
    """A case's job for one of the paper's gaits."""
    p = rr.RRRobotParameters()
    start = impulsive_rates(PAPER_GAITS)[gait]
    return Job(
        settings={"samples": 50, **case.settings}, steps=case.steps,
        offset=float(PAPER_GAITS.offset[gait]), phase=float(PAPER_GAITS.phase[gait]),
        amplitude=AMPLITUDE, omega=OMEGA, start=tuple(start.tolist()), radius=p.shell_radius,
        leg=p.leg_lengths[0], battery=p.battery_mass, servo=p.servo_masses[0],
        tip=p.leg_masses[0], gravity=p.gravity, damping=KAPPA, cycles=CYCLES, counted=COUNTED,
    )  # fmt: skip


def python_of(peer: Peer) -> str:
    """The Python that has the peer, whose environment is made if there is none yet."""
    if not peer.apart:
        return sys.executable
    folder = HOME / peer.package
    binary = folder / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
    if not (folder / ".ready").exists():
        HOME.mkdir(exist_ok=True)
        (HOME / ".gitignore").write_text("*\n")
        subprocess.run([sys.executable, "-m", "venv", "--clear", str(folder)], check=True)
        install = [str(binary), "-m", "pip", "install", "-q", peer.package, "numpy"]
        subprocess.run(install, check=True)
        (folder / ".ready").touch()
    return str(binary)


def ask(peer: Peer, question: Job) -> dict[str, Any]:
    """What the peer answers to a job.

    Raises:
        RuntimeError: it failed; with the end of what it said.
    """
    command = [python_of(peer), "-m", peer.module]
    done = subprocess.run(
        command, input=as_json(question), capture_output=True, text=True, cwd=ROOT,
        env={**os.environ, "OMP_NUM_THREADS": "1"},
    )  # fmt: skip
    if done.returncode:
        raise RuntimeError(f"{peer.module} failed:\n{done.stderr[-2000:]}")
    return dict(json.loads(done.stdout.strip().splitlines()[-1]))


def row(
    peer: str, release: str, model: str, step: float | None, timing: Timing,
    found: Motion, true: Motion, **more: Any,
) -> dict[str, Any]:  # fmt: skip
    """One line: times [s] of one gait of 30 s, signed relative errors of speed and yaw rate."""
    speed, yaw_rate = found.speed.tolist(), found.yaw_rate.tolist()
    return {
        "simulator": peer, "version": release, "model": model,
        "time_step_ms": None if step is None else 1e3 * step, **timing._asdict(),
        "speed": speed, "yaw_rate": yaw_rate,
        "speed_error": (found.speed / true.speed - 1).tolist(),
        "circular_yaw_rate_error": float(found.yaw_rate[1] / true.yaw_rate[1] - 1), **more,
    }  # fmt: skip


def other_rows(true: Motion, only: str | None) -> Iterator[dict[str, Any]]:
    """Every case; times are means of both gaits."""
    for case in CASES:
        if only not in (None, case.peer.lower()):
            continue
        peer = PEERS[case.peer]
        said = [ask(peer, job(case, gait)) for gait in range(2)]
        timing = Timing(*(float(np.mean([s[key] for s in said])) for key in Timing._fields))
        found = Motion(*(np.array([s[key] for s in said]) for key in ("speed", "yaw_rate")))
        low, high = zip(*(s["height"] for s in said), strict=True)
        yield row(
            case.peer, said[0]["version"], case.model,
            PERIOD / case.steps if case.fixed else None, timing, found, true,
            settings=case.settings, leg_error=max(s["leg_error"] for s in said),
            radius=rr.RRRobotParameters().shell_radius, height=[min(low), max(high)],
        )  # fmt: skip


def mujoco_rows(true: Motion) -> Iterator[dict[str, Any]]:
    """Some of the cases of `benchmarks.mujoco_peer` on the two gaits, on one thread, and one more.

    That one has a contact four times as stiff in time, which needs a quarter of the step.
    """
    from benchmarks.mujoco_peer import CASES as OURS
    from benchmarks.mujoco_peer import describe, sweep

    wanted = ("defaults, 2 ms", "no-slip settings, 1 ms", "no-slip settings, 4 ms",
              "no-slip and stiff contact, RK4, 1 ms")  # fmt: skip
    cases = [case for case in OURS if case.name in wanted and not case.free_joint]
    contact = cases[-1].contact.replace("solref='0.002 1'", "solref='0.0005 1'")
    name = "no-slip and stiffer contact, RK4, 0.25 ms"
    cases.append(replace(cases[-1], name=name, steps=4 * cases[-1].steps, contact=contact))
    for case in cases:
        run = sweep(case, PAPER_GAITS, threads=1)
        timing = Timing(run.timing.wall / 2, run.timing.core / 2)
        yield row(
            "MuJoCo", version("mujoco"), case.name.rsplit(", ", 1)[0], PERIOD / case.steps, timing,
            run.motion, true, settings=describe(case), leg_error=run.leg_error,
        )  # fmt: skip


def sympy_rows(true: Motion) -> Iterator[dict[str, Any]]:
    """KanesMethod through Numba on the two gaits."""
    from benchmarks.kane_peer import FORMS, simulator, starts

    omega = impulsive_rates(PAPER_GAITS)
    means = np.empty((2, CYCLES, 3))
    for form in FORMS:
        run = simulator(form)
        for steps in (80, 320):
            march = partial(
                run, PAPER_GAITS.offset, PAPER_GAITS.phase, starts(form, omega), steps, means
            )
            timing = median(repeated(march, 5))
            found = motion_of_means(means.transpose(1, 0, 2)[-COUNTED:])
            yield row(
                "SymPy", version("sympy"), f"KanesMethod, rolling as {form}, compiled, RK4",
                PERIOD / steps, Timing(timing.wall / 2, timing.core / 2), found, true,
            )  # fmt: skip


def own_rows(true: Motion) -> Iterator[dict[str, Any]]:
    """`simulate` both ways, warm, and the engine on many gaits at once."""
    release, model = version("rrrobot"), full_model()
    gaits = [PAPER_GAITS.gait(i) for i in range(2)]
    for method, name in (("kkt", "simulate, KKT on Pinocchio"), ("momentum", "simulate, momentum")):
        march = partial(
            rr.simulate, model, duration=CYCLES * PERIOD, sample_interval=PERIOD / 50, method=method
        )
        timings = [median(repeated(partial(march, gait), 3)) for gait in gaits]
        states = [march(gait).steady_state(after=(CYCLES - COUNTED) * PERIOD) for gait in gaits]
        found = Motion(*(np.array([getattr(s, k) for s in states]) for k in Motion._fields))
        timing = Timing(*(float(np.mean(both)) for both in zip(*timings, strict=True)))
        yield row("rrrobot", release, name, None, timing, found, true)
    from rrrobot.momentum.batch import lower

    setting = lower(model)
    found = engine_motion(engine(setting, PAPER_GAITS.gaits()))
    for some in (PAPER_GAITS.take([1]), plane(20, 20)):
        timing = median(repeated(partial(engine, setting, some.gaits()), 9))
        each = Timing(*(x / some.offset.size for x in timing))
        name = "one gait" if some.offset.size == 1 else f"one of {some.offset.size} gaits at once"
        yield row("rrrobot", release, f"engine, {name}", PERIOD / STEPS, each, found, true)


def truth() -> Motion:
    """Both gaits by the full model's KKT system, tolerances 1e-12."""
    both = [kkt_motion(PAPER_GAITS.gait(i)) for i in range(2)]
    return Motion(*(np.concatenate(part) for part in zip(*both, strict=True)))


def main() -> None:
    """Measure, print and write benchmarks/results/simulators.json."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", choices=[name.lower() for name in PEERS])
    parser.add_argument("--out", type=Path, default=RESULTS, help="folder of the JSON file")
    arguments = parser.parse_args()
    true = truth()
    if arguments.only:
        for line in other_rows(true, arguments.only):
            print(json.dumps(line), flush=True)
        return
    for peer in PEERS.values():
        python_of(peer)
    with recorded("simulators", arguments.out, "mujoco", "sympy") as results:
        results["true_answer"] = {k: v.tolist() for k, v in true._asdict().items()}
        results.update(cycles=CYCLES, counted=COUNTED, period=PERIOD)
        lines = results["lines"] = []
        for rows in (own_rows, sympy_rows, mujoco_rows, partial(other_rows, only=None)):
            for line in rows(true):
                lines.append(line)
                print(json.dumps(line), flush=True)


if __name__ == "__main__":
    main()
