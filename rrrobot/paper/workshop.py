"""What several tables and figures need, each computed once and when it is first wanted."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from rrrobot.drive.gaits import gait
from rrrobot.models.full import FullModel
from rrrobot.models.pivoting import PivotingModel
from rrrobot.models.recombined import DecoupledModels
from rrrobot.models.single_axis import PitchModel, RollModel, YawModel
from rrrobot.robot.robot import Robot
from rrrobot.studies.comparison import Comparison, compare
from rrrobot.studies.sweeps.run import sweep

if TYPE_CHECKING:
    import xarray as xr

FINE, COARSE = 41, 13
"""Values of each grid of the plane; both hold offsets pi/4 and pi/2, and phase difference pi/2."""
AMPLITUDE, FREQUENCY = 0.3, 8.0
"""Of the paper's gaits [rad], [rad/s]."""
CYCLES = 38
"""Whole cycles in 30 s at 8 rad/s."""
HUMP = 1.1
"""Ratio of `hump` from which an amplitude has one."""
_MODELS: dict[str, type] = {
    "full": FullModel,
    "pivoting": PivotingModel,
    "roll": RollModel,
    "pitch": PitchModel,
    "yaw": YawModel,
}


class Workshop:
    """RRRobot of Table 2, its two gaits, and sweeps over the paper's plane of gaits.

    Args:
        quick: coarse grids, and the momentum method for the two gaits, for a first look.
        robot: another with two legs and a spherical shell; RRRobot if None.

    Attributes:
        offset, phase_difference: the plane of gaits, 0 .. pi and 0 .. 2 pi [rad].
        full: the full model with the paper's damping.
    """

    def __init__(self, *, quick: bool = False, robot: Robot | None = None) -> None:
        self.quick = quick
        self.robot = robot or Robot.from_parameters()
        n = COARSE if quick else FINE
        self.offset = np.linspace(0.0, np.pi, n)
        self.phase_difference = np.linspace(0.0, 2 * np.pi, n)
        self.full = FullModel(self.robot)
        self._comparisons: dict[str, Comparison] = {}
        self._planes: dict[str, xr.Dataset] = {}

    def comparison(self, name: str) -> Comparison:
        """The models on the "lateral" or "circular" gait over 30 s."""
        if name not in self._comparisons:
            method = "momentum" if self.quick else "kkt"
            self._comparisons[name] = compare(self.robot, gait(name), method=method)
        return self._comparisons[name]

    def plane(self, name: str) -> xr.Dataset:
        """Sweep over the plane of a model: "full", "pivoting", "roll", "pitch", "yaw", "decoupled",
        or "modulated": decoupled with the yaw model's amplitude of Fig 20."""
        if name not in self._planes:
            model = _MODELS.get(name, DecoupledModels)(self.robot)
            self._planes[name] = sweep(
                model,
                offset=self.offset,
                phase_difference=self.phase_difference,
                amplitude=AMPLITUDE,
                angular_frequency=FREQUENCY,
                cycles=CYCLES,
                yaw_amplitude=self.yaw_amplitude if name == "modulated" else None,
                progress=False,
            )
        return self._planes[name]

    @cached_property
    def modulation(self) -> xr.DataArray:
        """Leg amplitude at which the yaw model drifts like the full model (offset,) [rad]."""
        from rrrobot.studies.modulation import amplitude_modulation

        return amplitude_modulation(self.robot, self.plane("full"))

    @cached_property
    def modulation_curve(self) -> xr.DataArray:
        """`modulation` on a four times finer row, for Fig 20: it falls steeply to its ends."""
        from rrrobot.studies.modulation import amplitude_modulation

        row = sweep(
            self.full,
            offset=np.linspace(0.0, np.pi, 4 * (self.offset.size - 1) + 1),
            phase_difference=[np.pi / 2, np.pi],
            amplitude=AMPLITUDE,
            angular_frequency=FREQUENCY,
            cycles=CYCLES,
            progress=False,
        )
        return amplitude_modulation(self.robot, row)

    @property
    def yaw_amplitude(self) -> xr.DataArray:
        """`modulation` with its gaps, where nothing drifts, filled in linearly."""
        from rrrobot.studies.modulation import filled

        return filled(self.modulation, self.modulation.offset)


def hump(amplitude: xr.DataArray) -> float:
    """Amplitude of opposite legs at offset pi/2 over that at pi/4."""
    row = amplitude.sel(phase_difference=np.pi, method="nearest")
    top, side = (row.sel(offset=o, method="nearest") for o in (np.pi / 2, np.pi / 4))
    return float(top / side)


def relative_rms(full: xr.DataArray, other: xr.DataArray) -> float:
    """Root mean square of other less full over that of full, on one plane."""
    return float(np.sqrt(((other - full) ** 2).mean() / (full**2).mean()))
