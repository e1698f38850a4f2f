"""Which gait is fastest, and which turns tightest? A search with a small budget."""

import json
from pathlib import Path

import numpy as np

import rrrobot as rr

out = Path("out")
out.mkdir(exist_ok=True)
model = rr.FullModel(rr.Robot.from_parameters())
bounds = {"amplitude": (0.1, 0.3), "angular_frequency": 8.0, "offset": (0.3, np.pi - 0.3)}

found = {}
for goal in (rr.studies.FastestTravel(), rr.studies.TightestTurn(min_speed=0.004)):
    best = rr.optimise(model, goal, tied=True, budget=400, seed=1, **bounds)
    state, name = best.steady_state, type(goal).__name__
    radius = 1 / abs(state.curvature) if state.curvature else np.inf
    print(f"{name}: {1000 * state.speed:.2f} mm/s, radius {radius:.3g} m")
    print(f"  {best.gait}")
    found[name] = {"gait": best.gait.to_dict(), "speed": state.speed, "yaw_rate": state.yaw_rate}

(out / "best_gaits.json").write_text(json.dumps(found, indent=2))
print(f"wrote {out / 'best_gaits.json'}")
