"""How fast must a disc roll to stay up? Above its critical speed it nods, below it leans far."""

from pathlib import Path

import numpy as np

import rrrobot as rr

out = Path("out")
out.mkdir(exist_ok=True)
m, r, A, C = 1.2, 0.3, 0.027, 0.054
disc = rr.machines.rolling_disc(m=m, r=r, A=A, C=C)
critical = np.sqrt(A * m * 9.81 * r / (C * (C + m * r**2)))
print(f"critical rate {critical:.6f} rad/s, sqrt(g / 3r) = {np.sqrt(9.81 / (3 * r)):.6f}")

for share in (0.95, 1.05):
    tilt = rr.rotations.quaternion_from_euler((1e-3, 0.0, 0.0))
    t = disc.simulate(
        None, 4.0, pose=disc.at(tilt), start=(0, share * critical, 0), sample_interval=0.02
    )
    lean = np.abs(t.wheel_angles[:, 1]).max()
    print(f"at {share:.2f} of it the disc leans to {np.rad2deg(lean):.2f} deg in 4 s")

# A wobble that turns over again and again: quaternions know no singular angle.
t = disc.simulate(
    None, 6.0, pose=disc.at(tilt), start=(2.0, -6.0, 1.0), sample_interval=0.02, rtol=1e-10
)
turns = np.ptp(t.wheel_angles[:, 2]) / (2 * np.pi)
print(f"{turns:.1f} turns, energy kept to {np.ptp(t.energy) / t.energy[0]:.0e}")
rr.record(t, out / "rolling_coin.html", axes=False)
print(f"wrote {out / 'rolling_coin.html'}")
