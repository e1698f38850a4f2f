"""What does my gait settle to, does it hold, and what does it depend on most?"""

from pathlib import Path

import rrrobot as rr

out = Path("out")
out.mkdir(exist_ok=True)

model = rr.FullModel(rr.Robot.from_parameters())
cycle = rr.limit_cycle(model, rr.gait("circular"))
print(cycle)
print(f"a deviation falls to 1/e in {max(cycle.settling_times):.2f} s")

effects = rr.orbits.sensitivities(cycle)
for name in effects.ranked("yaw_rate")[:3]:
    print(f"{name}: {effects.of('yaw_rate', name):+.4g} rad/s per unit")

cycle.plot().savefig(out / "cycle.png")
effects.plot("yaw_rate").figure.savefig(out / "effects.png")
print(f"wrote {out / 'cycle.png'} and {out / 'effects.png'}")
