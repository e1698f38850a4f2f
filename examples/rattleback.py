"""Why does a rattleback turn back? Spun one way its rattle grows and takes the spin away."""

from pathlib import Path

import numpy as np

import rrrobot as rr

out = Path("out")
out.mkdir(exist_ok=True)
half = np.deg2rad(0.5)

for spin in (5.0, -5.0):
    stone = rr.machines.rattleback(sigma=1e-4)
    tilt = rr.rotations.quaternion_from_euler((half, -half, 0.0))
    t = stone.simulate(None, 8.0, pose=stone.at(tilt), start=(0, 0, spin))
    about = t.body_velocity[:, 5]
    turned = np.flatnonzero(about * spin < -0.2 * spin**2)
    when = f"turns back at {t.time[turned[0]]:.2f} s" if turned.size else "goes on that way"
    print(f"spin {spin:+.0f} rad/s: {when}; at 8 s {about[-1]:+.2f} rad/s")
    if spin > 0:
        film = rr.record(t, out / "rattleback.html", axes=False, speed=0.5)
print(f"wrote {film}")
