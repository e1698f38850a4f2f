"""What if the legs were longer, or the battery heavier? Speed over two robot parameters."""

from pathlib import Path

import numpy as np

import rrrobot as rr
from rrrobot.figures.maps import value_map

out = Path("out")
out.mkdir(exist_ok=True)

ds = rr.sweep(
    rr.FullModel(rr.Robot.from_parameters()),
    offset=np.pi / 2,
    amplitude=0.3,
    angular_frequency=8.0,
    parameters={
        "leg_length": np.linspace(0.06, 0.11, 11),
        "battery_mass": np.linspace(0.2, 0.5, 13),
    },
)
for length in (0.06, 0.1, 0.11):
    row = ds.speed.sel(leg_length=length, method="nearest")
    heaviest = float(row.idxmax("battery_mass"))
    print(f"legs of {length} m travel fastest with a battery of {heaviest:.3f} kg", end=": ")
    print(f"{1000 * float(row.max()):.2f} mm/s")

# The pitch resonates with the legs where the battery's weight makes its own frequency theirs.
value_map(ds.speed).figure.savefig(out / "parameters.png")
print(f"wrote {out / 'parameters.png'}")
