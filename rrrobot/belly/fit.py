"""The belly of a robot: the shell, the posture, the rest and the range, one after another."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from rrrobot.belly.fitting import FORMS, Fit, ball_of, cone, fit_form, own_fit
from rrrobot.belly.found import Belly
from rrrobot.belly.placed import Gauge, floors, placed, touches, with_shell
from rrrobot.belly.posture import Posture, Search, find_posture, judged
from rrrobot.belly.ranges import AZIMUTHS, RollingRange, flat_end, rolling_range, round_end
from rrrobot.belly.rests import Rest, rest_of, standing
from rrrobot.belly.shapes import Shapes
from rrrobot.belly.underside import Underside, flat_face, rectangle, underside
from rrrobot.checks import Array, finite, vector
from rrrobot.contact.boulder import Boulder, depth_of_floor, is_rock
from rrrobot.contact.ground import Ground, Plane
from rrrobot.contact.shells import FlatBelly
from rrrobot.contact.surfaces import Sphere
from rrrobot.contact.touching import check_pair
from rrrobot.errors import ParameterError, ShellError, UrdfWarning
from rrrobot.models.full import FullModel
from rrrobot.robot.examples import example_robots
from rrrobot.robot.joints import JointIndex
from rrrobot.robot.robot import Robot

_ROUND = 0.02
"""Largest gap over the base's width up to which a belly is round by itself."""
_SIMPLER = 1.3
"""Gap over that of the next form up to which the simpler form is taken."""
_LEANS = 0.25
"""Part of the tilt by which a round shell may lean at rest and stay where its fit has put it."""
_FITS = 3
"""At most, after the first: each changes the posture, and that what is to be held."""
_ROOM = 0.06
"""Clearance that is wanted of a posture, over the base's width."""
_AROUND = np.append(0.0, np.tile(2 * np.pi * np.arange(12) / 12, 3))
"""Azimuths of the contacts over which limbs are to be clear; the first is straight down."""


def fit_belly(
    robot: Robot | str | Path,
    *,
    form: str = "auto",
    ground: Ground | None = None,
    posture: ArrayLike | None = None,
    tilt: float = float(np.deg2rad(15.0)),
    geometry: str = "collision",
    floor: float | None = None,
) -> Belly:
    """Find the belly of a robot: the shell around its underside, how it rests, how far it rolls.

    The base's underside is looked at along its own z axis, with motors and hips that would touch
    before it. On level ground, a slope or a bowl a smooth shell is fitted, on a boulder a flat
    underside is taken as it is.

    Args:
        robot: a Robot; the path of a URDF whose meshes are found from there (else a Robot with
            package_dirs=); or the name of one of `robot.example_robots()`.
        form: "sphere", "ellipsoid", "box" (the sum of two ellipsoids) or "flat"; "auto" takes the
            simplest that does. "own" takes a Robot's shell as it is, any `Surface` with its frame
            along the base's axes: a dome that is built, or of a shape of one's own.
        ground: what it lies on; level ground unless given.
        posture: legs (legs,) [rad]; searched for unless given: limbs clear of the ground and
            of each other, the centre of mass as low as that allows.
        tilt: angle by which the belly shall roll to each side [rad]; the dome of a flat belly
            grows with it.
        geometry: which shapes of the URDF count, "collision" or "visual".
        floor: how far the top of a boulder is above the floor, which the limbs of a posture that
            is searched for do not reach; no floor unless given [m].

    Raises:
        ShellError: the base has no shape; a flat belly on ground that is no boulder, or without a
            flat face below the centre of mass; an own shell that is turned, flat or none.
        ParameterError: a number or a word out of range.

    Warns:
        UrdfWarning: meshes that cannot be read, which are left out.

    Example:
        >>> import rrrobot as rr
        >>> belly = rr.fit_belly(rr.Robot.from_parameters())
        >>> belly.kind, belly.form, round(belly.shell.radius, 4)
        ('round', 'sphere', 0.12)
    """
    if form not in (*FORMS, "flat", "own", "auto"):
        raise ParameterError(f"form is {form!r}: it must be auto, {', '.join(FORMS)}, flat or own.")
    if form == "own" and not isinstance(robot, Robot):
        raise ShellError(
            f"form='own' takes the shell of a Robot, and robot is {robot!r}: make one with "
            "Robot.from_urdf(path, shell=, shell_center=) or Robot.from_example."
        )
    tilt = finite("tilt", tilt, "rad", above=0)
    if tilt > np.pi / 3:
        raise ParameterError(f"tilt is {tilt!r} rad: a belly is fitted for at most 60 degrees.")
    robot, ground = _robot_of(robot), Plane() if ground is None else ground
    floor = None if floor is None else depth_of_floor(ground, floor)
    shapes = Shapes.of(robot, geometry)
    if shapes.missing:
        warnings.warn(
            f"the belly of {robot.name} is fitted without meshes that cannot be read: "
            f"{'; '.join(shapes.missing)}. Say with package_dirs= where they lie.",
            UrdfWarning,
            stacklevel=2,
        )
    work = _Work(robot, ground, shapes, tilt, floor)
    if posture is None:
        angle, begin = None, np.clip(np.zeros(robot.n_legs), robot.joints.lower, robot.joints.upper)
    else:
        begin = angle = vector("posture", posture, robot.n_legs, "rad", broadcast=True)
    below = underside(shapes, begin, work.cone)
    middle: Array | None = None
    for left in range(_FITS, -1, -1):
        fitted = work.fitted(below, form, begin, middle)
        found = work.posture(below, fitted)
        chosen = found if angle is None else work.given(fitted, angle)
        belly = work.belly(below, fitted, chosen, found)
        if left and middle is None and work.leans(belly):
            # The belly's middle is far from the centre of mass: fit one that is not.
            middle = work.center_of_mass(chosen.leg_angle)[:2]
        elif left and work.pokes(belly):
            # Hips that the shell held before the posture turned them: fit them as they are now.
            below = underside(shapes, chosen.leg_angle, work.cone)
        else:
            break
    return belly


def _robot_of(robot: Robot | str | Path) -> Robot:
    if isinstance(robot, Robot):
        return robot
    still = Sphere(1.0)
    if isinstance(robot, str) and "/" not in robot and not robot.lstrip().startswith("<"):
        try:
            known = robot in example_robots()
        except ImportError:
            known = False
        if known:
            return Robot.from_example(robot, shell=still)
    return Robot.from_urdf(robot, shell=still)


class _Work:
    """The steps of a fit, on one robot."""

    def __init__(
        self, robot: Robot, ground: Ground, shapes: Shapes, tilt: float, floor: float | None
    ) -> None:
        self.robot, self.ground, self.shapes, self.tilt = robot, ground, shapes, tilt
        self.floor = floor
        self.cone = cone(tilt)

    def leans(self, belly: Belly) -> bool:
        """Whether a round shell leans by much of its range where it rests, or does not rest."""
        if isinstance(belly.shell, FlatBelly) or belly.margin.min() <= 0:
            return False
        return belly.rest is None or bool(np.abs(belly.rest[:2]).max() > _LEANS * self.tilt)

    def pokes(self, belly: Belly) -> bool:
        """Whether a link that the shell was to hold pokes out of it within the range."""
        return any(
            link in belly.covered and tilt < self.tilt
            for link, tilt in zip(belly.rolling_range.link, belly.rolling_range.tilt, strict=True)
        )

    def fitted(
        self, below: Underside, form: str, leg_angle: Array, middle: Array | None
    ) -> tuple[str, Fit]:
        """Kind and shell, its centre over a place (x, y) if one is given."""
        on_boulder = is_rock(self.ground)
        if form == "flat":
            check_pair(FlatBelly(), self.ground)
            return "flat", self._flat(below, leg_angle)
        allowed = _ROUND * below.width
        if form == "own":
            own = own_fit(self.robot, below.support, self.tilt)
            return "round" if own.error <= allowed else "dome", own
        ball = ball_of([*below.base, *below.covered], self.tilt, allowed)
        if ball is not None and form in ("auto", "sphere"):
            return "round", ball
        names = FORMS[:2] if form == "auto" else (form,)
        fits = [fit_form(name, below.support, self.tilt, middle) for name in names]
        fit = fits[0]
        if len(fits) > 1 and fits[0].error > _SIMPLER * fits[1].error:
            fit = fits[1]
        if fit.error <= allowed:
            return "round", fit
        if form == "auto" and on_boulder and self._face(below, leg_angle) is not None:
            return "flat", self._flat(below, leg_angle)
        return "dome", fit

    def center_of_mass(self, leg_angle: Array) -> Array:
        """In the base's frame (3,) [m]."""
        model, data = self.robot.model, self.robot.model.createData()
        q = pin.neutral(model)
        JointIndex(model, self.robot.legs).write(q, leg_angle)
        return np.array(pin.centerOfMass(model, data, q))

    def _face(self, below: Underside, leg_angle: Array) -> tuple[float, float] | None:
        face = flat_face(below.base)
        return None if face is None else rectangle(face, self.center_of_mass(leg_angle)[:2])

    def _flat(self, below: Underside, leg_angle: Array) -> Fit:
        """A flat belly whose frame is below the centre of mass."""
        face, middle = flat_face(below.base), self.center_of_mass(leg_angle)[:2]
        sides = None if face is None else rectangle(face, middle)
        if face is None or sides is None:
            raise ShellError(
                f"{self.robot.name} has no flat face below its centre of mass at "
                f"{np.round(middle, 4).tolist()} m of its base: it would tip. Swing the legs with "
                "posture=, or fit form='ellipsoid'."
            )
        center = np.array((*middle, face.height))
        return Fit("flat", FlatBelly(*sides), center, 0.0, 0.0)

    def _touches(self, fit: Fit) -> Any:
        """Contacts over which limbs are to be clear."""
        tilt = np.append(0.0, np.repeat(self.tilt * np.array((1 / 3, 2 / 3, 1.0)), 12))
        azimuth = _AROUND
        if isinstance(fit.shell, FlatBelly) and isinstance(self.ground, Boulder):
            tilt = np.minimum(tilt, flat_end(fit.shell, self.ground, azimuth))
        return touches(fit.shell, fit.center, self.ground, tilt, azimuth)

    def posture(self, below: Underside, fitted: tuple[str, Fit]) -> Posture:
        """The best posture."""
        fit, covered = fitted[1], frozenset(below.links)
        if not self.robot.n_legs:
            return Posture(np.zeros(0), np.inf)
        middle = fit.center[:2]
        if isinstance(fit.shell, FlatBelly):
            face = flat_face(below.base)
            assert face is not None
            middle = face.corners.mean(axis=0)
        room, at = _ROOM * below.width, self._touches(fit)
        floor = None if self.floor is None else floors(at, self.floor, _AROUND)
        return find_posture(Search(self.shapes, at, middle, room, covered, floor))

    def given(self, fitted: tuple[str, Fit], leg_angle: Array) -> Posture:
        """What a posture of the user's has."""
        return judged(self.shapes, self._touches(fitted[1]), leg_angle)

    def belly(
        self,
        below: Underside,
        fitted: tuple[str, Fit],
        chosen: Posture,
        best: Posture,
    ) -> Belly:
        kind, fit = fitted
        if kind == "flat":
            fit = self._flat(below, chosen.leg_angle)
            at = self._touches(fit)
            gap = Gauge(below.base, at.curvature)(at).min(axis=1)
            fit = fit._replace(error=float(np.abs(gap).max()))
        robot = with_shell(self.robot, fit.shell, fit.center)
        model = FullModel(robot, ground=self.ground, damping=None)
        height, radii = standing(model, chosen.leg_angle)
        rest = rest_of(model, chosen.leg_angle)
        pieces = placed(robot, self.shapes.pieces, chosen.leg_angle)
        limbs = [p for p in pieces if p.joint != 1 and p.link not in below.links]
        at = self._touches(fit)
        clear = float(Gauge(limbs, at.curvature)(at).min()) if limbs else float("inf")
        if kind != "dome":
            # What the belly itself is a part of touches by itself.
            pieces = [p for p in pieces if p.joint != 1]
        reach = rolling_range(
            fit.shell, fit.center, self.ground, pieces, self._end(kind, fit, below)
        )
        thickness = fit.thickness if kind == "dome" else 0.0
        return Belly(
            kind=kind, form=fit.form, shell=fit.shell, center=fit.center, error=fit.error,
            thickness=thickness, covered=below.links, face=self._face(below, chosen.leg_angle),
            robot=robot, ground=self.ground, posture=chosen.leg_angle, clearance=clear,
            separation=chosen.separation, height=height, radii=radii,
            resting=None if isinstance(rest, str) else rest, rolling_range=reach,
            reason=self._reason(model, chosen, best, rest, reach, (height, radii, clear)),
            shapes=Shapes(robot, self.shapes.pieces, self.shapes.missing),
            missing=self.shapes.missing,
        )  # fmt: skip

    def _end(self, kind: str, fit: Fit, below: Underside) -> tuple[Array, str]:
        """Tilts at which the belly itself ends, and the name for that."""
        if isinstance(fit.shell, FlatBelly) and isinstance(self.ground, Boulder):
            return flat_end(fit.shell, self.ground, AZIMUTHS), "edge of the belly"
        if kind == "dome":
            return np.full(len(AZIMUTHS), self.tilt), "rim of the dome"
        allowed = fit.error + _ROUND * below.width
        return round_end(fit.shell, fit.center, below.support, allowed), "end of the round part"

    def _reason(
        self,
        model: FullModel,
        chosen: Posture,
        best: Posture,
        rest: Rest | str,
        reach: RollingRange,
        stands: tuple[float, Array, float],
    ) -> str:
        """All that keeps it from rolling, in words."""
        said = []
        height, radii, clear = stands
        if radii.min() <= 0:
            said.append(
                "the ground curves tighter than the shell, which touches it at its rim: fit a "
                "rounder one with a larger tilt=, or take wider ground"
            )
        elif isinstance(rest, str) or not rest.stable:
            axis = ("roll", "pitch")[int(np.argmin(radii))]
            margin = float((radii - height).min())
            if margin <= 0:
                text = (
                    f"it tips over in {axis}: its centre of mass is {-1e3 * margin:.3g} mm above "
                    "the centre of curvature"
                )
                h, r = standing(model, best.leg_angle)
                if (r - h).min() > 0:
                    text += (
                        f"; legs at {np.round(best.leg_angle, 3).tolist()} rad put it "
                        f"{1e3 * float((r - h).min()):.3g} mm below"
                    )
                else:
                    text += (
                        f"; the lowest posture found leaves it {-1e3 * float((r - h).min()):.3g} "
                        "mm above: try a flatter shell, a smaller tilt= or a larger boulder"
                    )
                said.append(text)
            else:
                why = rest if isinstance(rest, str) else "its rest is not stable"
                said.append(f"it does not rest in this posture: {why}")
        if clear < 0:
            said.append(
                f"a limb is {-1e3 * clear:.3g} mm in the ground within "
                f"{np.rad2deg(self.tilt):.3g} degrees of tilt"
            )
        if chosen.separation < 0:
            said.append(f"two links are {-1e3 * chosen.separation:.3g} mm in each other")
        if reach.least == 0.0:
            text = f"{reach.link[int(np.argmin(reach.tilt))]} touches the ground at rest"
            if chosen is best:
                text += " in the best posture found within the joint limits"
            said.append(text)
        return "; ".join(said)
