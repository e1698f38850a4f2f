"""What `unstick` finds, kept on disk as it comes."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from rrrobot.belly.found import Belly
from rrrobot.errors import OutputError, ParameterError
from rrrobot.escape.confirming import EscapeGait, gait_of, why_not
from rrrobot.escape.goals import Escape, goal_of
from rrrobot.escape.limits import EscapeLimits
from rrrobot.escape.ways import RollOff, way_of
from rrrobot.files import write_whole
from rrrobot.inline import html_table
from rrrobot.models.base import Model

STORE = "unstick.json"
FORMAT = "rrrobot unstick 5"


@dataclass(frozen=True, kw_only=True, eq=False)
class Unstuck:
    """What `unstick` found.

    Attributes:
        belly: the belly, its rest and modes.
        limits: what gaits had to keep within.
        goals: that were asked for.
        found: goal's name -> gaits, the best first; if the first is not `met`, it is the nearest.
        off: goal's name -> how the robot rolls off its rock to that side, or why not.
        reasons: goal's name -> why there is no feasible gait, and what to try.
        damping: of the rocking, as plain data; None as long as no goal was searched for.
        search: what was asked of it (joints, groups, budget, ...), as plain data.
        folder: where results are kept, or None.

    Example:
        >>> import rrrobot as rr
        >>> found = rr.unstick("solo12", goals=["forward"])  # doctest: +SKIP
        >>> found.best("forward").met, found.reasons  # doctest: +SKIP
        (True, {})
    """

    belly: Belly
    limits: EscapeLimits
    goals: tuple[Escape, ...]
    found: Mapping[str, tuple[EscapeGait, ...]] = field(default_factory=dict)
    off: Mapping[str, RollOff] = field(default_factory=dict)
    reasons: Mapping[str, str] = field(default_factory=dict)
    damping: Mapping[str, Any] | None = None
    search: Mapping[str, Any] = field(default_factory=dict)
    folder: Path | None = None

    @property
    def unlimited(self) -> tuple[str, ...]:
        """Joints whose effort limit in the file is a placeholder, and so none."""
        return self.belly.robot.joints.unlimited

    @property
    def done(self) -> tuple[str, ...]:
        """Names of the goals that are searched."""
        gone = (name for name, way in self.off.items() if way.met)
        return tuple(dict.fromkeys((*self.found, *gone, *self.reasons)))

    @property
    def met(self) -> bool:
        """Whether there is a feasible way for every goal."""
        return all(goal.name in self.done and goal.name not in self.reasons for goal in self.goals)

    def best(self, goal: str | Escape) -> EscapeGait:
        """The best gait for a goal; where it is not `met`, the nearest.

        Raises:
            ParameterError: the goal was not asked for, or nothing settles on the way.
        """
        name = goal_of(goal).name
        if name in self.found:
            return self.found[name][0]
        if name in self.off and self.off[name].met:
            raise ParameterError(f"{name} takes no gait: off[{name!r}] says how.")
        why = self.reasons.get(name, f"the goals were {', '.join(g.name for g in self.goals)}")
        raise ParameterError(f"there is no gait {name!r}: {why}")

    @classmethod
    def begun(
        cls,
        belly: Belly,
        limits: EscapeLimits,
        goals: Sequence[Escape],
        folder: str | Path | None,
        search: Mapping[str, Any] | None = None,
    ) -> Unstuck:
        """Nothing yet, or what a folder holds of the same belly, limits and search."""
        own = cls(
            belly=belly, limits=limits, goals=tuple(goals), search=search or {},
            folder=None if folder is None else Path(folder),
        )  # fmt: skip
        return own if own.folder is None else own._resumed(own.folder)

    def known(self, model: Model) -> Unstuck:
        """With the model that is searched."""
        return replace(self, damping=model.damping.to_dict())

    def reached(self, goal: Escape, gaits: Sequence[EscapeGait]) -> Unstuck:
        """With the gaits of a goal."""
        reasons = dict(self.reasons)
        if not gaits[0].met and not goal.leans:
            reasons[goal.name] = why_not(gaits[0])
        new = replace(self, found={**self.found, goal.name: tuple(gaits)}, reasons=reasons)
        for i, gait in enumerate(gaits if new.folder is not None else ()):
            assert new.folder is not None
            gait.trajectory.save(new.folder / _run_name(goal.name, i))
        return new._kept()

    def rolled(self, goal: Escape, way: RollOff) -> Unstuck:
        """With what came of rolling off a rock."""
        new = replace(self, off={**self.off, goal.name: way})
        if not way.met:
            return replace(new, reasons={**self.reasons, goal.name: way.reason})
        if new.folder is not None:
            way.trajectory.save(new.folder / _run_name(goal.name, 0))
            if way.after is not None:
                way.after.trajectory.save(new.folder / f"{way.after_name}.npz")
        return new._kept()

    def failed(self, goal: Escape, reason: str) -> Unstuck:
        """With a goal that nothing reaches."""
        said = [self.off[goal.name].reason] if goal.name in self.off else []
        return replace(
            self, reasons={**self.reasons, goal.name: "; ".join([*said, reason])}
        )._kept()

    def stopped(self, reason: str) -> Unstuck:
        """With no goal reached, for one reason."""
        said = (
            f"{reason.rstrip('.')}. Try another form= or tilt= in fit_belly, other legs with "
            "posture=, or another ground=: on a rock legs may hang, and a larger one tips less."
        )
        return replace(self, reasons={goal.name: said for goal in self.goals})._kept()

    def to_dict(self) -> dict[str, Any]:
        """Everything but the trajectories as plain data."""
        return {
            "robot": self.belly.robot.name,
            "belly": self.belly.to_dict(),
            "limits": self.limits.to_dict(),
            "goals": [goal.name for goal in self.goals],
            "gaits": {name: [g.to_dict() for g in gaits] for name, gaits in self.found.items()},
            "off": {name: way.to_dict() for name, way in self.off.items()},
            "reasons": dict(self.reasons),
            "unlimited": list(self.unlimited),
            "damping": self.damping,
        }

    def _repr_html_(self) -> str:
        rows = {goal.name: self._told(goal) for goal in self.goals}
        return html_table(f"Ways of {self.belly.robot.name}", rows)

    def __repr__(self) -> str:
        told = ", ".join(f"{goal.name}: {self._told(goal)}" for goal in self.goals)
        return f"Unstuck({self.belly.robot.name}: {told})"

    def _told(self, goal: Escape) -> str:
        if goal.name in self.off and self.off[goal.name].met:
            return f"off the rock in {self.off[goal.name].duration:.3g} s"
        if goal.name not in self.found:
            return self.reasons.get(goal.name, "not searched")
        best = self.best(goal)
        state = "" if best.met else f", NOT FEASIBLE: {self.reasons[goal.name]}"
        return f"{best.value:.4g} {goal.unit}{state}"

    def save(self, folder: str | Path, *, films: bool = True) -> list[Path]:
        """Write report.html, films and files for the robot; see `rrrobot.escape.report`."""
        from rrrobot.escape.report import write_report

        return write_report(self, folder, films=films)

    # On disk

    def _key(self) -> str:
        parts = [self.belly.robot.to_dict(), self.belly.ground.to_dict(), self.limits.to_dict()]
        for part in parts:
            part.pop("package_dirs", None)
        parts += [{"posture": self.belly.posture.tolist()}, dict(self.search)]
        return hashlib.sha256(json.dumps(parts, sort_keys=True).encode()).hexdigest()[:32]

    def _kept(self) -> Unstuck:
        if self.folder is not None:
            self.folder.mkdir(parents=True, exist_ok=True)
            data = {"format": FORMAT, "key": self._key(), **self.to_dict()}
            text = json.dumps(_plain(data), indent=1, allow_nan=False)
            write_whole(self.folder / STORE, (text + "\n").encode())
        return self

    def _resumed(self, folder: Path) -> Unstuck:
        path = folder / STORE
        if not path.exists():
            folder.mkdir(parents=True, exist_ok=True)
            return self
        try:
            data = json.loads(path.read_text(encoding="utf-8"))
            if data["format"] != FORMAT or data["key"] != self._key():
                raise OutputError(
                    f"{str(folder)!r} holds the results of another robot, ground, posture, limits "
                    "or search: give another folder, or delete it."
                )
            found = {
                name: tuple(
                    gait_of(entry, folder / _run_name(name, i)) for i, entry in enumerate(entries)
                )
                for name, entries in data["gaits"].items()
            }
            off = {
                name: way_of(entry, folder, _run_name(name, 0))
                for name, entry in data["off"].items()
                if entry["met"]
            }
            return replace(
                self, found=found, off=off, reasons=dict(data["reasons"]), damping=data["damping"]
            )
        except (KeyError, TypeError, ValueError, OSError) as error:
            raise OutputError(
                f"{str(path)!r} is damaged ({error}): delete it, and the search begins anew."
            ) from None


def _run_name(goal: str, i: int) -> str:
    return f"{goal_of(goal).file_name}{'' if i == 0 else f'_{i + 1}'}.npz"


def _plain(data: Any) -> Any:
    if isinstance(data, Mapping):
        return {str(key): _plain(value) for key, value in data.items()}
    if isinstance(data, (list, tuple)):
        return [_plain(value) for value in data]
    if isinstance(data, float):
        return data if np.isfinite(data) else None
    return data
