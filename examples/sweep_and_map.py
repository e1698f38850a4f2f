"""How do speed and turning depend on the gait? A plane of gaits as maps, kept in a file."""

from pathlib import Path

import numpy as np

import rrrobot as rr
from rrrobot.figures.maps import inverse, translation

out = Path("out")
out.mkdir(exist_ok=True)

plane = rr.sweep(
    rr.FullModel(rr.Robot.from_parameters()),
    offset=np.linspace(0, np.pi, 25),
    phase_difference=np.linspace(0, 2 * np.pi, 25),
    store=out / "plane.nc",  # run the script again and nothing is computed anew
)
best = plane.speed.where(plane.speed == plane.speed.max(), drop=True)
print(plane[["speed", "yaw_rate", "curvature"]])
print(f"fastest: {1000 * float(best.max()):.2f} mm/s at offset {float(best.offset[0]):.3f} rad")

translation(plane).savefig(out / "plane.png")
inverse(plane).savefig(out / "plane_inverse.png")
for name in ("plane.nc", "plane.png", "plane_inverse.png"):
    print(f"wrote {out / name}")
