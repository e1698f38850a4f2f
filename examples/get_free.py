"""How does a six-legged robot get free that lies on its belly? A report, gaits for its joints."""

from pathlib import Path

import rrrobot as rr

# Any URDF would do; this one is made from a few lengths and masses.
urdf = rr.robot.legged_urdf(6, n_joints=2, body_size=(0.5, 0.25, 0.1), leg_mass=0.4)
belly = rr.fit_belly(urdf, form="sphere")
print(belly)

found = rr.unstick(belly, goals=["forward"], budget=1500, postures=2)
print(found)

for path in found.save(Path("get_free"), films=False):
    print("wrote", path)
