"""Does a gait of my own travel? A Fourier series and a function of time, beside a sinusoid."""

from pathlib import Path

import numpy as np

import rrrobot as rr

out = Path("out")
out.mkdir(exist_ok=True)
model = rr.FullModel(rr.Robot.from_parameters())

# Squarer swings: a third harmonic on each leg; leg 2 is a quarter cycle ahead.
fourier = rr.FourierGait(
    offset=(np.pi / 3, np.pi / 3),
    sine=[[0.34, 0.0], [0.0, 0.0], [0.06, 0.0]],
    cosine=[[0.0, 0.34], [0.0, 0.0], [0.0, -0.06]],
    angular_frequency=8.0,
)


def kick(time: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """One leg swings, the other is held: angle, rate and acceleration, checked by rrrobot."""
    s, c = np.sin(8.0 * time), np.cos(8.0 * time)
    return np.array([1.0 + 0.5 * s, 2.0]), np.array([4.0 * c, 0.0]), np.array([-32.0 * s, 0.0])


gaits = {
    "sinusoid": rr.SinusoidalGait(
        offset=np.pi / 3, amplitude=0.3, angular_frequency=8.0, phase=(0.0, np.pi / 2)
    ),
    "fourier": fourier,
    "one leg": rr.CallableGait(kick, n_legs=2, period=np.pi / 4),
}
for name, gait in gaits.items():
    motion = rr.simulate(model, gait, duration=20.0, method="momentum")
    state = motion.steady_state()
    print(f"{name:>8}: {1000 * state.speed:6.3f} mm/s, {state.yaw_rate:+.5f} rad/s")
    path = out / f"gait_{name.replace(' ', '_')}.png"
    motion.plot("path").figure.savefig(path)
    print(f"wrote {path}")
