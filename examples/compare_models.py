"""How far can the simple models be trusted? Full, pivoting and single-axis on one gait."""

from pathlib import Path

import rrrobot as rr
from rrrobot.figures.comparison import contact_paths

out = Path("out")
out.mkdir(exist_ok=True)

both = rr.studies.compare(rr.Robot.from_parameters(), rr.gait("circular"), duration=9.0)
print(f"{'model':>10}  {'mm/s':>7}  {'rad/s':>8}  {'travel':>7}  {'turning':>7}")
for row in both.rows():
    ratios = "  ".join(f"{row[key]:7.3f}" for key in ("speed_ratio", "yaw_rate_ratio"))
    print(f"{row['model']:>10}  {1000 * row['speed']:7.3f}  {row['yaw_rate']:8.5f}  {ratios}")

shown = ("full", "pivoting", "decoupled")
contact_paths(both, shown, marks=(0.0, 3.0, 6.0, 9.0)).savefig(out / "models.png")
print(f"wrote {out / 'models.png'}")
