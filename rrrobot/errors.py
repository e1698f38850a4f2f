"""Every error of the package: one root, and each kin also a child of the built-in it resembles."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import xarray as xr

# What an error carries is of rooms that stand above this one, which it does not name.
Carried = Any
_LONGEST = 2000
"""Characters of a message; a file's or a user's own words may be longer than anybody reads."""


def shortened(text: str, longest: int = _LONGEST) -> str:
    """A text of at most so many characters, cut in its middle where it is longer."""
    if len(text) <= longest:
        return text
    return f"{text[: 3 * longest // 4 - 5]} ... {text[-longest // 4 :]}"


class RRRobotError(Exception):
    """Root of all errors that rrrobot raises on purpose.

    Example:
        >>> import rrrobot as rr
        >>> try:
        ...     rr.RRRobotParameters(leg_mass=-1.0)
        ... except rr.RRRobotError as error:
        ...     print(error)
        leg_mass is -1.0 kg: it must be greater than zero and finite.
    """

    def __init__(self, *args: object) -> None:
        super().__init__(*(shortened(arg) if isinstance(arg, str) else arg for arg in args))


class ParameterError(RRRobotError, ValueError):
    """A physical parameter, a step, a duration or an option is out of range."""


class UrdfError(RRRobotError, ValueError):
    """A URDF is missing, malformed, hostile, or lacks what was asked of it."""


class ShellError(RRRobotError, ValueError):
    """A shell that is not what a model or a constraint needs."""


class GaitError(RRRobotError, ValueError):
    """Leg trajectories or torques of the wrong size, or not finite, or not smooth."""


class ModelError(RRRobotError, ValueError):
    """A model was asked for something that it cannot give."""


class ConstraintError(RRRobotError, ArithmeticError):
    """The KKT system is singular or not finite."""


class OrbitError(RRRobotError, ArithmeticError):
    """No motion that repeats was found, or it leaves what the model can describe."""


class OutputError(RRRobotError, OSError):
    """A file cannot be written or read back."""


class MissingExtraError(RRRobotError, ImportError):
    """An optional dependency is not installed."""


class SimulationError(RRRobotError, RuntimeError):
    """A simulation had to stop.

    Attributes:
        time: time of the stop [s].
        state: the model's state vector at that time.
        trajectory: a `Trajectory` of all samples up to the stop, or None if there are none.
    """

    def __init__(
        self,
        message: str,
        *,
        time: float,
        state: object = None,
        trajectory: Carried = None,
    ) -> None:
        super().__init__(message)
        self.time = time
        self.state = state
        self.trajectory = trajectory

    def __reduce__(self) -> tuple[Any, ...]:
        parts: dict[str, Any] = {
            "time": self.time,
            "state": self.state,
            "trajectory": self.trajectory,
        }
        return (partial(type(self), **parts), self.args)


class SimulationInterrupted(SimulationError, KeyboardInterrupt):
    """Ctrl-C during a simulation; `trajectory` holds what was computed."""


class SweepInterrupted(RRRobotError, RuntimeError, KeyboardInterrupt):
    """Ctrl-C during a sweep; `dataset` holds what was computed, the rest of it is NaN."""

    def __init__(self, message: str, dataset: xr.Dataset | None = None) -> None:
        super().__init__(message)
        self.dataset = dataset

    def __reduce__(self) -> tuple[Any, ...]:
        return (type(self), (str(self), self.dataset))


class SweepError(OutputError, RuntimeError):
    """A sweep's store or one of its workers failed; `dataset` holds what was computed."""

    def __init__(self, message: str, dataset: xr.Dataset | None = None) -> None:
        super().__init__(message)
        self.dataset = dataset

    def __reduce__(self) -> tuple[Any, ...]:
        return (type(self), (str(self), self.dataset))


class BranchInterrupted(RRRobotError, RuntimeError, KeyboardInterrupt):
    """Ctrl-C while a branch was followed; `branch`, a `Branch`, holds its points so far."""

    def __init__(self, message: str, branch: Carried = None) -> None:
        super().__init__(message)
        self.branch = branch

    def __reduce__(self) -> tuple[Any, ...]:
        return (type(self), (str(self), self.branch))


class PlanError(RRRobotError, RuntimeError):
    """No plan was found.

    Attributes:
        nearest: the `Plan` that ends nearest to the goal, or None if there is none.
    """

    def __init__(self, message: str, *, nearest: Carried = None) -> None:
        super().__init__(message)
        self.nearest = nearest

    def __reduce__(self) -> tuple[Any, ...]:
        return (partial(type(self), nearest=self.nearest), self.args)


class GroundClearanceWarning(UserWarning):
    """A leg can touch the ground, which no model here takes into account."""


class SlowWarning(UserWarning):
    """A run takes long; the message says how many steps and why."""


class UrdfWarning(UserWarning):
    """A robot's file says what no body can have, or what no model here takes into account."""


class LimitWarning(UserWarning):
    """A motion passes a limit that the robot's file sets to a joint."""


class UnsettledWarning(UserWarning):
    """Cycle means were taken of a motion that still changes from cycle to cycle."""
