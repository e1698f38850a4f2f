"""Cost of the full model: one evaluation and its parts, 30 s of a gait, and the import.

Run with `make benchmark`. Medians of one run; the ratio to Pinocchio's own constrained forward
dynamics on the same constraint is what compares between machines.
"""

from __future__ import annotations

import json
import statistics
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pinocchio as pin

import rrrobot as rr
from rrrobot.simulation.evaluate import versions

TARGETS = {"dynamics [us]": 60.0, "gait of 30 s [s]": 1.0, "import rrrobot [s]": 0.4}


def microseconds(function: Callable[[], object], repeats: int = 30, calls: int = 300) -> float:
    """Median time of a call [us]."""
    function()
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        for _ in range(calls):
            function()
        times.append((time.perf_counter() - start) / calls)
    return 1e6 * statistics.median(times)


def evaluation() -> dict[str, float]:
    robot = rr.Robot.from_parameters()
    model = rr.FullModel(robot)
    gait = rr.gait("circular")
    pose = model.make_pose((0.1, 0.2, 0.3), (0.0, 0.0))
    omega, leg = np.array((0.5, -0.4, 0.7)), gait(0.3)
    place = model.place(pose)
    q, v = model.configuration(place, leg.angle), model.velocity(place, omega, leg.rate)
    pin_model, data = robot.model, robot.model.createData()
    rows = model.rolling.evaluate(data, q, v)
    legs = rr.constraints.PrescribedJoints(model.legs.v, pin_model.nv).evaluate(
        data, q, v, legs=leg
    )
    mass, bias = pin.crba(pin_model, data, q), pin.nonLinearEffects(pin_model, data, q, v)
    tau = np.zeros(pin_model.nv)
    system = rr.kkt_build(mass, bias, tau, rows, legs)
    jacobian = np.vstack((rows.jacobian, legs.jacobian))
    drift = np.concatenate((rows.drift, legs.drift))
    return {
        "dynamics [us]": microseconds(lambda: model.dynamics(pose, omega, leg)),
        "  placement of the body [us]": microseconds(lambda: model.place(pose)),
        "  Pinocchio's CRBA [us]": microseconds(lambda: pin.crba(pin_model, data, q)),
        "  Pinocchio's C v + G [us]": microseconds(
            lambda: pin.nonLinearEffects(pin_model, data, q, v)
        ),
        "  rolling rows [us]": microseconds(lambda: model.rolling.evaluate(data, q, v)),
        "  KKT build [us]": microseconds(lambda: rr.kkt_build(mass, bias, tau, rows, legs)),
        "  KKT solve [us]": microseconds(lambda: rr.kkt_solve(system)),
        "  damping [us]": microseconds(lambda: model.damping_force(place, omega)),
        "gait [us]": microseconds(lambda: gait(0.3)),
        "pin.forwardDynamics, rows given [us]": microseconds(
            lambda: pin.forwardDynamics(pin_model, data, q, v, tau, jacobian, drift, 0.0)
        ),
    }


def simulation() -> dict[str, float]:
    model = rr.FullModel(rr.Robot.from_parameters())
    seconds, evaluations = [], 0
    for _ in range(5):
        start = time.perf_counter()
        t = rr.simulate(model, rr.gait("circular"), duration=30.0)
        seconds.append(time.perf_counter() - start)
        evaluations = t.metadata["integration"]["evaluations"]
    return {"gait of 30 s [s]": statistics.median(seconds), "  evaluations": evaluations}


def importing() -> dict[str, float]:
    def run(code: str) -> float:
        start = time.perf_counter()
        subprocess.run([sys.executable, "-c", code], check=True)
        return time.perf_counter() - start

    found = {}
    for name, code in (("rrrobot", "import rrrobot"), ("pinocchio", "import pinocchio")):
        empty = statistics.median(run("pass") for _ in range(5))
        found[f"import {name} [s]"] = statistics.median(run(code) for _ in range(5)) - empty
    return found


def main() -> None:
    """Measure, print, and write out/benchmark_full_model.json."""
    results = evaluation() | simulation() | importing()
    for name, value in results.items():
        target = f"   target {TARGETS[name]:g}" if name in TARGETS else ""
        print(f"{name:40s} {value:10.3g}{target}")
    ratio = results["dynamics [us]"] / results["pin.forwardDynamics, rows given [us]"]
    print(f"{'dynamics / pin.forwardDynamics':40s} {ratio:10.3g}")
    out = Path("out")
    out.mkdir(exist_ok=True)
    report = {"results": results, "versions": versions()}
    (out / "benchmark_full_model.json").write_text(json.dumps(report, indent=1))


if __name__ == "__main__":
    main()
