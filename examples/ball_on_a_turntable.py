"""Where does a ball go on a turntable? It circles, once in seven halves of the table's turns."""

from pathlib import Path

import numpy as np

import rrrobot as rr

out = Path("out")
out.mkdir(exist_ok=True)
rate, r = 2.0, 0.1
table = rr.machines.turntable_ball(rate=rate, r=r)

for x, v in (((0.5, 0.0), (0.0, 0.0)), ((0.3, 0.1), (0.2, -0.15))):
    # The ball rolls: its angular velocity follows from its velocity over the table.
    slip = v[0] + rate * x[1], v[1] - rate * x[0]
    omega = (-slip[1] / r, slip[0] / r, 0.0)
    t = table.simulate(
        None, 3.5 * 2 * np.pi / rate, pose=(*x, r, 0, 0, 0, 1), start=omega, sample_interval=0.05,
        rtol=1e-10,
    )  # fmt: skip
    away = np.linalg.norm(t.pose[-1, :2] - x)
    centre = (t.pose[:, :2].max(axis=0) + t.pose[:, :2].min(axis=0)) / 2
    print(f"from {x}: about {centre.round(3)}, back to {away:.0e} m, energy is not kept: "
          f"{t.energy.min():.3f} .. {t.energy.max():.3f} J")  # fmt: skip

rr.record(t, out / "turntable.html", axes=False)
print(f"wrote {out / 'turntable.html'}")
