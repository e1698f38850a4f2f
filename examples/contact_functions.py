"""How do I roll my own Pinocchio model? Contact point, Jacobian and drift, and a check of them."""

from pathlib import Path

import numpy as np
import pinocchio as pin

import rrrobot as rr

# Any model will do; here an arm that presses a ball against a wall.
model = pin.buildSampleModelManipulator()
ball = model.addFrame(
    pin.Frame("ball", model.njoints - 1, pin.SE3.Identity(), pin.FrameType.OP_FRAME)
)
shell, wall = rr.Sphere(0.05), np.array([0.0, 1.0, 0.0])
rng = np.random.default_rng(0)
q, v = pin.randomConfiguration(model), rng.normal(size=model.nv)

point = rr.contact_point(model, q, ball, shell, wall)
jacobian = rr.contact_jacobian(model, q, ball, shell, wall)
drift = rr.contact_drift(model, q, v, ball, shell, wall)

# The drift is the rate of J v along the motion with constant v.
h = 1e-5
ahead, behind = (
    rr.contact_jacobian(model, pin.integrate(model, q, s * v), ball, shell, wall) @ v
    for s in (h, -h)
)
error = np.abs((ahead - behind) / (2 * h) - drift).max()

out = Path("out")
out.mkdir(exist_ok=True)
lines = [
    f"contact point [m]: {point.round(4)}",
    f"slip velocity J v [m/s]: {(jacobian @ v).round(4)}",
    f"drift [m/s^2]: {drift.round(4)}, finite difference within {error:.1e}",
]
print("\n".join(lines))
(out / "contact.txt").write_text("\n".join(lines))
print(f"wrote {out / 'contact.txt'}")
