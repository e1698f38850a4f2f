"""How fast does the robot rock by itself? Periods by formula, linearisation and simulation."""

from pathlib import Path

import numpy as np

import rrrobot as rr

out = Path("out")
out.mkdir(exist_ok=True)
robot, up = rr.Robot.from_parameters(), (np.pi / 2, np.pi / 2)
rolling = rr.FullModel(robot, damping=None)

print("Table 3 [s]: paper, linear, simulated")
for row in rr.orbits.table_3():
    print(f"  {row.model:>8} {row.axis:>5}: {row.paper:.2f} {row.linear:.4f} {row.simulated:.4f}")

# Other legs, another rest: the modes there.
for leg in (np.pi / 2, np.pi / 4, 0.0):
    found = rr.orbits.modes(rolling, (leg, leg))
    text = ", ".join(f"{m.axis} {m.period:.3f} s" for m in found if np.isfinite(m.period))
    print(f"legs at {np.rad2deg(leg):.0f} deg: {text}")

# Large swings are slower.
for swing in (0.05, 0.5, 1.0):
    motion = rr.simulate(rolling, rr.StillLegs(up), 6.0, euler=(0, swing, 0), start="rest")
    print(f"pitch of {swing} rad: {rr.orbits.measured_period(motion, 'pitch'):.4f} s")
    loss = np.ptp(motion.energy) / motion.energy[0]
    print(f"  energy kept to {loss:.0e}")

motion.plot("angles").figure.savefig(out / "rocking.png")
print(f"wrote {out / 'rocking.png'}")
