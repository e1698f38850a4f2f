"""The flow by the contact momentum, and the forms of a flow by their names."""

from __future__ import annotations

from rrrobot.checks import Array
from rrrobot.drive.gaits import Gait
from rrrobot.errors import GaitError
from rrrobot.integrate import Integration
from rrrobot.models.base import Model
from rrrobot.simulation.effort import Effort
from rrrobot.simulation.events import Event, Hit, Lookout
from rrrobot.simulation.flow import Drive, Flow
from rrrobot.simulation.memory import Recall
from rrrobot.simulation.state import State
from rrrobot.simulation.track import Track


class MomentumFlow(Flow):
    """The flow by the contact momentum: prescribed legs, any shell and ground of ours, fixed steps.

    Every sample interval is divided into equal steps of at most `step`.

    Raises:
        GaitError: the legs are driven by torques.
        ParameterError: a tolerance, which would do nothing.
    """

    method = "momentum"

    def __init__(
        self,
        model: Model,
        drive: Drive,
        *,
        step: float | None = None,
        rtol: float | None = None,
        atol: float | None = None,
    ) -> None:
        # Numba loads here, so that it costs nobody who does not use it.
        from rrrobot.momentum.terrain import fineness

        self._refuse("method 'momentum', whose steps are fixed: set step=", rtol=rtol, atol=atol)
        super().__init__(model, drive, step=step)
        if not isinstance(drive, Gait):
            raise GaitError("method 'momentum' needs a prescribed gait; use 'kkt' for torques.")
        longest = self.stepping.max_step / fineness(model.robot.shell)
        self.stepping = self.stepping._replace(step=self.stepping.step or longest)

    def _run(
        self,
        state: State,
        times: Array,
        recall: Recall | None,
        track: Track,
        events: tuple[Event, ...],
        effort: Effort,
    ) -> tuple[Integration, Array | None, tuple[Hit, ...]]:
        from rrrobot.momentum.run import run

        lookout = Lookout(events, self.look, self.size) if events else None
        longest = self.stepping.step or self.stepping.max_step
        result, lane = run(
            self.model,
            self.drive,  # type: ignore[arg-type]
            state.vector,
            times,
            longest,
            observer=track,
            watch=lookout,
            progress=effort.told,
            lane=state.lane if state.drive == self.drive.to_dict() else None,
        )
        return result, lane, () if lookout is None else tuple(lookout.hits)


FLOWS: dict[str, type[Flow]] = {"kkt": Flow, "momentum": MomentumFlow}
"""By the name that `simulate` calls a method."""
