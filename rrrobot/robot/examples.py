"""Robots of example-robot-data (extra `robots`)."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from rrrobot.errors import MissingExtraError, UrdfError

UNSTICK = (
    "solo8", "solo12", "anymal", "anymal_c", "a1", "go1", "go2", "b1", "laikago", "hyq", "bolt",
)  # fmt: skip
"""Robots whose bellies and gaits are tried: `rrrobot unstick` runs on them out of the box."""


def example_robots() -> tuple[str, ...]:
    """Names that `Robot.from_example` takes (extra `robots`).

    Example:
        >>> import rrrobot as rr
        >>> "solo12" in rr.robot.example_robots()
        True
    """
    return tuple(sorted(n for n, loader in _example_loaders().items() if loader.urdf_filename))


def _example_loaders() -> dict[str, Any]:
    try:
        from example_robot_data.robots_loader import ROBOTS
    except ImportError as error:
        raise MissingExtraError(
            "example robots need the extra 'robots': pip install 'rrrobot[robots]'."
        ) from error
    return dict(ROBOTS)


def example_urdf(name: str) -> tuple[Path, Path]:
    """URDF file of an example robot, and the folder of its `package://` names.

    Raises:
        MissingExtraError: the extra is not installed.
        UrdfError: no such robot.
    """
    known = example_robots()
    if name not in known:
        raise UrdfError(f"there is no example robot {name!r}; there are: {', '.join(known)}.")
    from example_robot_data.robots_loader import getModelPath

    loader = _example_loaders()[name]
    relative = Path(loader.path, loader.urdf_subpath, loader.urdf_filename)
    folder = Path(loader.model_path or getModelPath(str(relative)))
    return folder / relative, folder.parent.parent
