"""What an optimiser found, as files: gait, goal, limits, model and robot, and the way back."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from rrrobot import serial
from rrrobot.drive.tables import gait_from_dict
from rrrobot.errors import OutputError
from rrrobot.files import write_whole
from rrrobot.models import model_from_dict
from rrrobot.models.base import Model
from rrrobot.robot.robot import Robot
from rrrobot.studies.optimisation.goals import Goal
from rrrobot.studies.optimisation.table import GaitLimits


def write_result(path: str | Path, data: Mapping[str, Any]) -> Path:
    """Write a result's `to_dict` as .json, whole or not at all.

    Raises:
        OutputError: the file cannot be written, or its name does not end in .json.
    """
    target = Path(path)
    if target.suffix.lower() != ".json":
        raise OutputError(f"cannot write {str(target)!r}: what an optimiser found ends in .json.")
    return write_whole(target, (json.dumps(data, indent=1, allow_nan=False) + "\n").encode())


@contextmanager
def reading(path: str | Path) -> Iterator[None]:
    """Whatever does not fit while a file is read is said of the file.

    Raises:
        OutputError: the file is missing, damaged, or of something else.
    """
    try:
        yield
    except FileNotFoundError:
        raise OutputError(f"there is no file {str(path)!r}: check the path.") from None
    except OutputError:
        raise
    except KeyError as error:
        raise OutputError(
            f"{str(path)!r} is not what an optimiser of this rrrobot saved: it has no {error}."
        ) from None
    except (OSError, ValueError, LookupError, TypeError, AttributeError) as error:
        raise OutputError(
            f"{str(path)!r} is not what an optimiser of rrrobot saved: {str(error).rstrip('.')}."
        ) from None


def read_result(path: str | Path) -> dict[str, Any]:
    """What `write_result` wrote, with its parts made anew; to be called within `reading`.

    Gaits, goals, shells and grounds of a class of one's own come back if `rrrobot.register` has it.
    """
    data: dict[str, Any] = json.loads(Path(path).read_text(encoding="utf-8"))
    made = {"model": _model(data), "limits": GaitLimits.from_dict(data["limits"])}
    if "points" in data:
        return data | made | {"gaits": [gait_from_dict(p["gait"]) for p in data["points"]]}
    goal: Goal = serial.from_dict(data["goal"], Goal, "goal")  # type: ignore[type-abstract]
    return data | made | {"goal": goal, "gait": gait_from_dict(data["gait"])}


def _model(data: Mapping[str, Any]) -> Model:
    return model_from_dict(data["model"], Robot.from_dict(data["robot"]))
