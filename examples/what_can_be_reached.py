"""Which speeds and curvatures can the robot reach, and which gait gives one of them?"""

from pathlib import Path

import rrrobot as rr
from rrrobot.steering.motions import motions_of

out = Path("out")
out.mkdir(exist_ok=True)
model = rr.FullModel(rr.Robot.from_parameters())
motions = motions_of(model)

for name in ("forward", "backward", "left", "right"):
    gear = rr.steering.Gear(motions, name)
    low, high = gear.curvature
    print(f"{name}: {1000 * gear.fastest(0):.1f} mm/s straight, {low:.1f} to {high:.1f} 1/m")

gear = rr.steering.Gear(motions, "left")
drive = gear.drive(speed=0.015, curvature=2.0)
print(f"15 mm/s on a circle of half a metre: offset {drive.offset:.4f} rad, "
      f"amplitude {drive.amplitude:.4f} rad, leg 2 ahead by {drive.phase_difference:.4f}"
)  # fmt: skip
print("30 mm/s there:", "yes" if gear.reaches(0.03, 2.0) else "no, but",
      f"{1000 * gear.fastest(2.0):.1f} mm/s")  # fmt: skip

rr.steering.reachable_set(motions).savefig(out / "reachable.png")
print(f"wrote {out / 'reachable.png'}")
