"""Does RRRobot roll? Its two gaits: speed and yaw rate beside independent values, plots, a film."""

from pathlib import Path

import rrrobot as rr
from rrrobot.view.films import record

DURATION, SETTLED = 30.0, 15.0  # [s]
# Independent Kane derivation, cycle means after 15 s: speed [m/s], yaw rate [rad/s].
REFERENCE = {"lateral": (0.009656, 0.0), "circular": (0.0066765, 0.0208546)}

out = Path("out")
out.mkdir(exist_ok=True)
robot = rr.Robot.from_parameters(rr.RRRobotParameters())  # Table 2
model = rr.FullModel(robot)
print(robot)

lines = []
written = []
for name, (speed, yaw_rate) in REFERENCE.items():
    trajectory = rr.simulate(model, rr.gait(name), duration=DURATION, progress=True)
    settled = trajectory.steady_state(after=SETTLED)
    for symbol, unit, value, reference in (
        ("v", "m/s", settled.speed, speed),
        ("alpha", "rad/s", settled.yaw_rate, yaw_rate),
    ):
        ratio = f"{value / reference:9.4f}" if reference else "        -"
        value = round(value, 7) + 0.0  # no minus before zero
        lines.append(f"{name:<9} {symbol:<6} {unit:<6} {value:12.7f} {reference:12.7f} {ratio}")
    picture = out / f"{name}.png"
    trajectory.plot("all").savefig(picture, dpi=150)
    written.append(picture)

print(f"{'gait':<9} {'':<6} {'unit':<6} {'rrrobot':>12} {'reference':>12} {'ratio':>9}")
print("\n".join(lines))
print("reference: independent Kane derivation, cycle means after 15 s")

written.append(record(trajectory, out / "circular.html"))
for path in written:
    print(f"wrote {path}")
