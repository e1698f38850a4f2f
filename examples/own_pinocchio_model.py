"""How do I simulate my own Pinocchio model? A ball on a free-flyer that rolls as its legs swing."""

from pathlib import Path

import numpy as np
import pinocchio as pin
from scipy.integrate import solve_ivp

import rrrobot as rr

# Any model with a free-flyer will do; here two rods on a ball, whose frame is `ball`.
model = pin.Model()
base = model.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), "base")
body = pin.Inertia(1.0, np.array((0.0, 0.0, -0.05)), 2e-3 * np.eye(3))
model.appendBodyToJoint(base, body, pin.SE3.Identity())
ball = model.addFrame(pin.Frame("ball", base, pin.SE3.Identity(), pin.FrameType.OP_FRAME))
for name, y in (("left", 0.1), ("right", -0.1)):
    place = pin.SE3(np.eye(3), np.array((0.0, y, 0.0)))
    leg = model.addJoint(base, pin.JointModelRY(), place, name)
    rod = pin.Inertia(0.1, np.array((0.0, 0.0, 0.1)), 1e-4 * np.eye(3))
    model.appendBodyToJoint(leg, rod, pin.SE3.Identity())
data = model.createData()

gait = rr.SinusoidalGait(offset=0.0, amplitude=0.3, angular_frequency=8.0, phase=(0.0, np.pi / 2))
rolls = rr.RollingContact(model, ball, rr.Sphere(0.15))
swings = rr.constraints.PrescribedJoints([6, 7], nv=model.nv)


def rate(time, state):
    """(q, v) to their rates: the KKT system of M, C v + G and the two constraints."""
    q, v = pin.normalize(model, state[: model.nq]), state[model.nq :]
    mass, bias = pin.crba(model, data, q), pin.nonLinearEffects(model, data, q, v)
    rows = [rolls.evaluate(data, q, v), swings.evaluate(data, q, v, legs=gait(time))]
    tau = np.zeros(model.nv)
    tau[3:6] = -0.01 * v[3:6]  # losses of the rolling
    acceleration = rr.kkt_solve(rr.kkt_build(mass, bias, tau, *rows)).acceleration
    x, y, z, w = q[3:7]
    turn = 0.5 * np.array(((w, -z, y), (z, w, -x), (-y, x, w), (-x, -y, -z))) @ v[3:6]
    moved = pin.Quaternion(q[3:7]).matrix() @ v[:3]
    return np.concatenate((moved, turn, v[6:], acceleration))


q, v = pin.neutral(model), np.zeros(model.nv)
q[2], q[7:], v[6:] = 0.15, gait(0.0).angle, gait(0.0).rate
run = solve_ivp(rate, (0.0, 10.0), np.concatenate((q, v)), rtol=1e-8, atol=1e-8)

out = Path("out")
out.mkdir(exist_ok=True)
np.savetxt(out / "own.csv", np.column_stack((run.t, run.y.T)), delimiter=",")
print(f"after 10 s the ball is at {run.y[:2, -1].round(4)} m,")
print(f"its centre within {np.abs(run.y[2] - 0.15).max():.1e} m of its radius above the ground")
print(f"wrote {out / 'own.csv'}")
