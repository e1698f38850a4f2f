"""How does my gait look? A film in one HTML file that plays in any browser, and its path."""

from pathlib import Path

import numpy as np

import rrrobot as rr

out = Path("out")
out.mkdir(exist_ok=True)

# Legs at different heights, one swinging wider; RampIn starts them from rest.
gait = rr.RampIn(
    rr.SinusoidalGait(
        offset=(1.0, 1.4), amplitude=(0.4, 0.3), angular_frequency=8.0, phase=(0.0, np.pi / 2)
    ),
    duration=2.0,
)
motion = rr.simulate(
    rr.FullModel(rr.Robot.from_parameters()), gait, duration=12.0, start="rest", method="momentum"
)
print(motion)
print(f"wrote {rr.record(motion, out / 'my_gait.html')}")
motion.plot("all").savefig(out / "my_gait.png")
print(f"wrote {out / 'my_gait.png'}")
