"""What `fit_belly` finds: a belly, how it rests and how far it rolls."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from rrrobot.belly.ranges import RollingRange
from rrrobot.belly.rests import Rest
from rrrobot.belly.shapes import Shapes
from rrrobot.checks import Array
from rrrobot.contact.ground import Ground
from rrrobot.contact.shells import FlatBelly
from rrrobot.contact.surfaces import Surface
from rrrobot.models.full import FullModel
from rrrobot.orbits.oscillations import Mode
from rrrobot.robot.robot import Robot


@dataclass(frozen=True, kw_only=True, eq=False)
class Belly:
    """What `fit_belly` found.

    Attributes:
        kind: "round", the underside rolls like the shell; "flat", it rolls on a boulder as it is;
            "dome", it is flat or has edges, and the shell is what would have to be added.
        form: of the shell: "sphere", "ellipsoid", "box", "flat" or "own".
        shell: the belly.
        center: of the shell, in the base's frame (3,) [m].
        error: largest gap between shell and underside, over the normals of the fit [m].
        thickness: of what would have to be added, straight below; 0 of flat and round ones [m].
        covered: links beside the base that the shell holds, since they would touch first.
        face: half length and half width of the largest rectangle of the flat face below the centre
            of mass [m], or None where it stands on less.
        robot: the robot with this belly; its legs and locked joints are those it had.
        ground: what it lies on.
        posture: the legs (legs,) [rad].
        clearance: least distance of a limb from the ground over the fit's tilts, by Coal [m].
        separation: least distance of two links in the posture, by Coal [m].
        height: of the centre of mass over the contact, upright [m].
        radii: of belly and ground together, (H^-1 + B)^-1, for roll and for pitch (2,) [m].
        resting: the rest with its modes, or None.
        rolling_range: how far it may roll in the posture.
        reason: why it is not fit to roll, empty if it is.
        shapes: the pieces of the robot.
        missing: meshes that could not be read, and why.
    """

    kind: str
    form: str
    shell: Surface
    center: Array
    error: float
    thickness: float
    covered: tuple[str, ...]
    face: tuple[float, float] | None
    robot: Robot
    ground: Ground
    posture: Array
    clearance: float
    separation: float
    height: float
    radii: Array
    resting: Rest | None
    rolling_range: RollingRange
    reason: str
    shapes: Shapes = field(repr=False)
    missing: tuple[str, ...] = ()

    @property
    def shell_depth(self) -> float:
        """Height of the shell's centre over its lowest point, upright [m]; 0 of a flat belly."""
        if isinstance(self.shell, FlatBelly):
            return 0.0
        return -float(self.shell.contact(np.array((0.0, 0.0, -1.0)))[2])

    @property
    def margin(self) -> Array:
        """How far the centre of mass is below the centre of curvature, roll and pitch (2,) [m]."""
        return self.radii - self.height

    @property
    def stable(self) -> bool:
        """Whether it rests, and no small deviation grows."""
        return self.resting is not None and self.resting.stable

    @property
    def rest(self) -> Array | None:
        """Euler angles of the rest (3,) [rad], or None."""
        return None if self.resting is None else self.resting.euler

    @property
    def modes(self) -> tuple[Mode, ...]:
        """Undamped modes about the rest; none where it does not rest."""
        return () if self.resting is None else self.resting.modes

    def model(self, **options: Any) -> FullModel:
        """The robot on its ground.

        Args:
            **options: as for `FullModel`.
        """
        return FullModel(self.robot, ground=self.ground, **options)

    def plot(self, ax: Any = None) -> Any:
        """Two sections of the shell over the robot's pieces; see `rrrobot.belly.picture`."""
        from rrrobot.belly.picture import sections

        return sections(self, ax)

    def to_dict(self) -> dict[str, Any]:
        """All numbers as plain data."""
        return {
            "robot": self.robot.name,
            "kind": self.kind,
            "form": self.form,
            "shell": self.shell.to_dict(),
            "center": self.center.tolist(),
            "error": self.error,
            "thickness": self.thickness,
            "covered": list(self.covered),
            "face": None if self.face is None else list(self.face),
            "ground": self.ground.to_dict(),
            "posture": dict(zip(self.robot.legs, self.posture.tolist(), strict=True)),
            "clearance": self.clearance,
            "separation": self.separation,
            "height": self.height,
            "radii": self.radii.tolist(),
            "margin": self.margin.tolist(),
            "stable": self.stable,
            "rest": None if self.rest is None else self.rest.tolist(),
            "modes": [
                {"axis": m.axis, "period": m.period, "decay_rate": m.decay_rate} for m in self.modes
            ],
            "rolling_range": self.rolling_range.to_dict(),
            "reason": self.reason,
            "missing": list(self.missing),
        }

    def __repr__(self) -> str:
        degrees = np.rad2deg(self.rolling_range.least)
        said = "" if not self.reason else f", but {self.reason}"
        return (
            f"Belly({self.kind} belly of {self.robot.name}: {self.form}, error "
            f"{1e3 * self.error:.3g} mm, {1e3 * self.thickness:.3g} mm added, centre of mass "
            f"{1e3 * self.margin.min():.3g} mm below the centre of curvature, rolls "
            f"{degrees:.3g} deg{said})"
        )
