"""What a robot's gaits can do, as motions in the plane: the reachable set and its corners.

Settled, a gait moves the cycle-mean pose (x, y, yaw) along a fixed screw: a velocity (u, v) along
the body's mean x and y axes and a yaw rate. Over all gaits within the bounds these fill a region;
its corners, the vertices of the convex hull, are the motions that are worth driving with, for any
other is slower than some mixture of them in every direction.
"""

from __future__ import annotations

import hashlib
import json
import os
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rrrobot.checks import Array, finite
from rrrobot.contact.ground import Plane
from rrrobot.errors import ModelError, ParameterError
from rrrobot.files import write_whole
from rrrobot.models.base import Model
from rrrobot.models.full import FullModel
from rrrobot.models.recombined import DecoupledModels
from rrrobot.progress import Progress
from rrrobot.studies.modulation import amplitude_modulation, filled
from rrrobot.studies.sweeps.run import sweep

if TYPE_CHECKING:
    import xarray as xr

_OFFSETS, _PHASES, _SHARES = 25, 48, (1.0, 0.6)


class Motions(NamedTuple):
    """Settled motions of sinusoidal gaits of one frequency, one a row."""

    twist: Array
    """(u, v, yaw rate) along the mean body axes (n, 3) [m/s, m/s, rad/s]"""
    offset: Array
    """of both legs (n,) [rad]"""
    amplitude: Array
    """(n,) [rad]"""
    phase_difference: Array
    """of leg 2 from leg 1 (n,) [rad]"""
    yaw_amplitude: Array
    """of the yaw model's legs where the models are decoupled, else the amplitude (n,) [rad]"""
    angular_frequency: float
    """[rad/s]"""

    def take(self, rows: NDArray[Any]) -> Motions:
        """Some of them."""
        twist, *others = (np.asarray(column)[rows] for column in self[:5])
        return Motions(twist, others[0], others[1], others[2], others[3], self.angular_frequency)


def motions_of(
    model: Model,
    *,
    amplitude: float = 0.5,
    angular_frequency: float = 8.0,
    decoupled: bool = False,
    store: bool = True,
    progress: Progress = None,
) -> Motions:
    """Settled motions over offsets of 0 to pi, all phase differences, and two amplitudes.

    Computed once for a robot and kept in the user's cache folder, by everything they depend on.

    Args:
        model: a model with two legs that the momentum engine knows; of one on a slope, the
            motions on level ground, which are the same at every heading.
        amplitude: the largest [rad].
        angular_frequency: [rad/s].
        decoupled: of the robot's single-axis models, recombined, with the yaw model's legs
            modulated so that it turns like the full model (the paper's Figs 19 and 20).
        store: whether to read and write the cache.
        progress: as for `sweep`.

    Raises:
        ModelError: the robot has not two legs, or no gait travels.

    Example:
        >>> import rrrobot as rr
        >>> from rrrobot.steering.motions import motions_of
        >>> found = motions_of(rr.FullModel(rr.Robot.from_parameters()))
        >>> bool(0.02 < abs(found.twist[:, 1]).max() < 0.03)  # sideways, m/s
        True
    """
    check_legs(model)
    amplitude = finite("amplitude", amplitude, "rad", above=0)
    model = _level(model)
    path = _cache_path(model, amplitude, angular_frequency, decoupled)
    kept = _read(path, angular_frequency) if store else None
    if kept is not None:
        return kept
    apart: dict[str, Any] = {}
    if decoupled:
        apart["yaw_amplitude"] = yaw_amplitudes(model, amplitude, angular_frequency)
    ds = sweep(
        DecoupledModels(model.robot) if decoupled else model,
        offset=np.linspace(0.0, np.pi, _OFFSETS),
        phase_difference=np.linspace(0.0, 2 * np.pi, _PHASES, endpoint=False),
        amplitude=amplitude * np.array(_SHARES),
        angular_frequency=angular_frequency,
        settle=_way(model),
        progress=progress,
        **apart,
    )
    ds = ds.squeeze("angular_frequency") if "angular_frequency" in ds.dims else ds
    names = ["velocity_x", "velocity_y", "yaw_rate", "variation"]
    if decoupled:
        ds = ds.assign(yaw_legs=ds.yaw_model_amplitude)
        names.append("yaw_legs")
    table = ds[names].to_dataframe().reset_index()
    twist = table[["velocity_x", "velocity_y", "yaw_rate"]].to_numpy()
    sound = np.all(np.isfinite(twist), axis=1) & (table["variation"].to_numpy() < 0.01)
    if not sound.any() or np.abs(twist[sound]).max() < 1e-9:
        raise ModelError(
            "no gait of this robot travels (are its legs without mass, or is there only one?): "
            "nothing can be planned."
        )
    found = Motions(
        twist[sound],
        table["offset"].to_numpy()[sound],
        table["amplitude"].to_numpy()[sound],
        table["phase_difference"].to_numpy()[sound],
        table["yaw_legs" if decoupled else "amplitude"].to_numpy()[sound],
        angular_frequency,
    )
    if store:
        _write(path, found)
    return found


def check_legs(model: Model) -> None:
    """That the robot has two legs, and no more.

    Raises:
        ModelError: it has not.
    """
    if model.n_legs != 2:
        raise ModelError(
            f"the robot has {model.n_legs} leg joints: plans are made of gaits of two legs; name "
            "two with legs=, the others are held."
        )


def yaw_amplitudes(model: Model, amplitude: float, angular_frequency: float) -> xr.DataArray:
    """Leg amplitudes at which the yaw model turns like the full one (amplitude, offset) [rad]."""
    import xarray as xr

    rows = []
    for share in _SHARES:
        full = sweep(
            model, offset=np.linspace(0.0, np.pi, _OFFSETS), phase_difference=np.pi / 2,
            amplitude=amplitude * share, angular_frequency=angular_frequency,
        )  # fmt: skip
        if "phase_difference" not in full.dims:
            full = full.expand_dims("phase_difference")
        modulation = amplitude_modulation(model.robot, full)
        rows.append(filled(modulation, full.offset).expand_dims(amplitude=[amplitude * share]))
    return xr.concat(rows, "amplitude")


def _level(model: Model) -> Model:
    """The same robot on level ground."""
    if type(model) is not FullModel or type(model.ground) is not Plane or model.ground.is_level:
        return model
    flat = Plane(gravity=model.ground.gravity)
    return FullModel(model.robot, ground=flat, damping=model.damping)


def _way(model: Model) -> str:
    """How its motions are found: by limit cycles, where the ground is level."""
    return "orbit" if type(model.ground) is Plane and model.ground.is_level else "cycles"


def corners(motions: Motions, *, most: int = 12, cost: Array | None = None) -> Motions:
    """Corners of the hull of all twists: few that reach nearly as far as all, in every direction.

    Each is chosen where those before it fall short the most.

    Args:
        motions: settled motions.
        most: how many at most.
        cost: of a second of each (n,), such as its power; that of reaching far is then the least.
    """
    if most < 2:
        raise ParameterError(f"most is {most}: at least 2 motions are needed.")
    scaled = motions.twist if cost is None else motions.twist / cost[:, None]
    scaled = scaled / np.maximum(np.abs(scaled).max(axis=0), 1e-300)
    directions = np.random.default_rng(0).normal(size=(500, 3))
    reach = scaled @ directions.T
    furthest, far = reach.argmax(axis=0), reach.max(axis=0)
    chosen = [int(furthest[0])]
    while len(chosen) < most:
        short = 1.0 - reach[chosen].max(axis=0) / np.maximum(far, 1e-300)
        worst = int(short.argmax())
        if short[worst] < 0.02:
            break
        chosen.append(int(furthest[worst]))
    return motions.take(np.array(chosen))


def _cache_path(model: Model, amplitude: float, angular_frequency: float, decoupled: bool) -> Path:
    """File for everything that the motions depend on."""
    what = [
        model.robot.to_dict(), model.to_dict(), amplitude, angular_frequency,
        _OFFSETS, _PHASES, _SHARES, decoupled, _way(model),
    ]  # fmt: skip
    name = hashlib.sha256(json.dumps(what, sort_keys=True).encode()).hexdigest()[:24]
    home = os.environ.get("XDG_CACHE_HOME") or os.path.join(os.path.expanduser("~"), ".cache")
    return Path(home) / "rrrobot" / "motions" / f"{name}.npy"


def _read(path: Path, angular_frequency: float) -> Motions | None:
    try:
        rows = np.load(path, allow_pickle=False)
    except (OSError, ValueError, EOFError):
        return None
    if rows.ndim != 2 or rows.shape[1] != 7 or not np.all(np.isfinite(rows)):
        return None
    offset, swing, phase, yaw = rows[:, 3:].T
    return Motions(rows[:, :3], offset, swing, phase, yaw, angular_frequency)


def _write(path: Path, found: Motions) -> None:
    import io

    buffer = io.BytesIO()
    np.save(buffer, np.column_stack(found[:5]))
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        write_whole(path, buffer.getvalue())
    except OSError:
        pass  # a home that cannot be written only costs time
