"""What does a ball do that rolls inside a ball that rolls? Both roll without slip, and go about."""

from pathlib import Path

import numpy as np

import rrrobot as rr
from rrrobot.machines import Joint, Link, Machine, Mechanism, Tree
from rrrobot.machines.looks import rotor

out = Path("out")
out.mkdir(exist_ok=True)
R, r, hollow = 0.2, 0.06, 0.19

# The inner ball has three slides and a spherical joint: it is free but for the contact.
inner = Link("inner", 0.5, 0.4 * 0.5 * r**2, looks=rotor("y", r))
slides = [
    Joint("along", "shell", Link("x"), axis="x", kind="slide"),
    Joint("across", "x", Link("y"), axis="y", kind="slide"),
    Joint("up", "y", Link("z"), axis="z", kind="slide"),
    Joint("turn", "z", inner, kind="ball"),
]
tree = Tree(Link("shell", 0.6, 2 / 3 * 0.6 * R**2), slides)
model = tree.model()
shell, ball = model.getFrameId("shell"), model.getFrameId("inner")
contacts = (
    rr.constraints.RollingContact(model, shell, rr.Sphere(R)),
    rr.rows.RollingOnBody(model, shell, ball, (hollow, r), inside=True),
)
pair = Machine(
    name="wheel_in_a_ball",
    title="a ball that rolls inside a ball",
    tree=tree,
    model=Mechanism(model, contacts),
)

# Let go at 50 degrees up the side.
tilt, lever = np.deg2rad(50), hollow - r
start = {"along": lever * np.sin(tilt), "up": -lever * np.cos(tilt)}
t = pair.simulate(None, 6.0, passive=start, sample_interval=0.02, rtol=1e-10, atol=1e-11)
apart = np.linalg.norm(t.states[:, 7:10], axis=1)
print(f"energy kept to {np.ptp(t.energy) / t.energy[0]:.0e} of itself")
print(f"centres stay {lever} m apart to {np.abs(apart - lever).max():.0e} m")
print(f"the shell rocks over {np.ptp(t.pose[:, 0]):.3f} m")
push = np.linalg.norm(t.multipliers["inner contact"], axis=1)
print(f"the inner ball presses with {push.min():.2f} to {push.max():.2f} N")

rr.record(t, out / "wheel_in_a_ball.html", axes=False)
print(f"wrote {out / 'wheel_in_a_ball.html'}")
