"""How does the robot keep to a path, though its masses and the camera are not as believed?"""

from pathlib import Path

import numpy as np

import rrrobot as rr
from rrrobot.steering import Sensor, Track, follow

out = Path("out")
out.mkdir(exist_ok=True)
believed = rr.FullModel(rr.Robot.from_parameters())
real = rr.FullModel(
    rr.Robot.from_parameters(rr.RRRobotParameters(leg_mass=(0.0595, 0.0539), battery_mass=0.285))
)
# Noise of 1 mm and half a degree; what is seen arrives one leg cycle late.
camera = Sensor(place=1e-3, yaw=np.deg2rad(0.5), delay=1)

run = follow(believed, Track.eight(0.5), 240.0, speed=0.008, truth=real, sensor=camera)
print(f"{len(run.time)} cycles, root mean square {1000 * run.rms:.2f} mm from the path")

lost = follow(believed, Track([(0, 0), (1, 0)]), 60.0, sensor=Sensor(jumps_after=12.0))
print(f"a camera that sees something else: {lost.stopped}")

run.plot().figure.savefig(out / "eight.png")
print(f"wrote {out / 'eight.png'}")
