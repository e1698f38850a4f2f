"""Sliders of one client, and the numbers above them."""

from __future__ import annotations

import html
import math
import threading
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from rrrobot.drive.gaits import gait as named_gait
from rrrobot.lab.knobs import BODY, OVERTONES, Knobs
from rrrobot.lab.outcome import Outcome
from rrrobot.robot.robot import Robot

_UNITS = {
    "leg_mass": ("leg mass [g]", 1e3, 5.0, 150.0),
    "servo_mass": ("servo mass [g]", 1e3, 5.0, 200.0),
    "battery_mass": ("battery [g]", 1e3, 20.0, 600.0),
    "leg_length": ("leg length [mm]", 1e3, 20.0, 119.0),
    "shell_radius": ("radius [mm]", 1e3, 121.0, 300.0),
}
"""Label, factor, and range around the paper's values."""
_DEG = 180 / math.pi
_FREE = "choose a preset"
_FEW = 4
"""Legs whose sliders are all open at first."""
_STRAIGHT = 0.02
"""Curvature of a circle of fifty metres [1/m]."""


class Panel:
    """The sliders; tells of each that is moved by the person, and can be set.

    Args:
        gui: of a client of viser.
        robot: the laboratory's.
        knobs: where they stand at first.
        turned: called with new knobs after each move.
    """

    def __init__(
        self, gui: Any, robot: Robot, knobs: Knobs, turned: Callable[[Knobs], None]
    ) -> None:
        self.gui, self.robot, self.knobs = gui, robot, knobs
        self._turned = turned
        self._read: list[Callable[[], None]] = []
        """what brings each slider to where the knobs stand"""
        self._sliders: dict[str, list[tuple[Any, Callable[[], float]]]] = {}
        """by the entry of the knobs, with where they say that it stands"""
        self._lock = threading.RLock()
        """of the knobs: viser tells of moves on several threads"""
        self._others: list[Any] = []
        self._offered: dict[str, dict[str, Any]] = {}

    def gait_tab(self) -> None:
        """Presets, and each leg's sliders."""
        gui, legs = self.gui, self.robot.legs
        if self.robot.parameters is None:
            self._keep("as opened", self.knobs)
        self._preset = gui.add_dropdown("preset", (_FREE, *presets(self.robot), *self._offered))
        self._preset.on_update(self._choose)
        if len(legs) > 1:
            self.tied = gui.add_checkbox(
                "legs tied",
                _alike(self.knobs),
                hint="Offset and amplitude of all legs move together.",
            )
            self.tied.on_update(lambda event: self._tie())
        top = max(20.0, math.ceil(1.5 * self.knobs.frequency))
        self._slider("frequency [rad/s]", "frequency", None, 1.0, 0.5, top, 0.05)
        for k, leg in enumerate(legs):
            with gui.add_folder(leg, expand_by_default=len(legs) <= _FEW):
                pair = (
                    self._slider("offset [deg]", "offset", k, _DEG, -180.0, 180.0, 0.1),
                    self._slider("amplitude [deg]", "amplitude", k, _DEG, 0.0, 90.0, 0.1),
                )
                if k:
                    self._others += pair
                self._slider("phase [deg]", "phase", k, _DEG, -180.0, 180.0, 0.1)
        with gui.add_folder("harmonics", expand_by_default=False):
            for row, order in enumerate(OVERTONES):
                for k, leg in enumerate(legs):
                    name = f"{order}nd" if order == 2 else f"{order}rd"
                    self._slider(f"{name}, {leg} [deg]", "overtone", (row, k), _DEG, 0.0, 45.0, 0.1)
                    self._slider(
                        f"{name} phase [deg]", "overtone_phase", (row, k), _DEG, -180, 180, 0.1
                    )
        self._tie()

    def robot_tab(self) -> None:
        """Losses, gravity, slope; masses and radius of RRRobot."""
        gui = self.gui
        top = 5 * max(self.knobs.damping, 0.01)
        self._slider("damping [mN m s]", "damping", None, 1e3, 0.0, 1e3 * top, 0.01)
        kinds = gui.add_dropdown(
            "losses on", ("euler", "body"), initial_value=self.knobs.damping_kind,
            hint="Rates of roll, pitch and yaw, as the paper; or rates about the body's axes.",
        )  # fmt: skip
        kinds.on_update(lambda event: self._set(event, damping_kind=kinds.value))
        self._read.append(lambda: _assign(kinds, self.knobs.damping_kind))
        self._slider("gravity [m/s²]", "gravity", None, 1.0, 0.5, 25.0, 0.01)
        self._slider("slope [deg]", "slope", None, _DEG, -10.0, 10.0, 0.05)
        self._slider("friction of ground", "friction", None, 1.0, 0.0, 1.5, 0.01)
        for k, value in enumerate(self.knobs.body):
            label, factor, low, high = _UNITS[BODY[k]]
            low, high = min(low, factor * value), max(high, factor * value)
            self._slider(label, "body", k, factor, low, high, 0.1)

    def horizon(self) -> None:
        """How far the path is drawn."""
        self._slider("path over [s]", "horizon", None, 1.0, 5.0, 300.0, 1.0)

    def show(self, knobs: Knobs) -> None:
        """Bring all sliders to where the knobs stand."""
        with self._lock:
            self.knobs = knobs
            for read in self._read:
                read()

    def offer(self, name: str, knobs: Knobs) -> None:
        """One more preset, and bring all sliders there."""
        self._keep(name, knobs)
        self._preset.options = (_FREE, *presets(self.robot), *self._offered)
        self._preset.value = name
        self._untie(knobs)
        self.show(knobs)

    def _keep(self, name: str, knobs: Knobs) -> None:
        entries = ("offset", "amplitude", "phase", "frequency")
        self._offered[name] = {entry: getattr(knobs, entry) for entry in entries}

    def _untie(self, knobs: Knobs) -> None:
        """Untie the legs if these knobs have them differ."""
        if self.robot.n_legs > 1 and not _alike(knobs):
            self.tied.value = False
            self._tie()

    def _slider(
        self, label: str, name: str, at: Any, factor: float, low: float, high: float, step: float
    ) -> Any:
        """A slider of one number of the knobs, at `at` of its tuple."""

        def value() -> float:
            shown = factor * _entry(getattr(self.knobs, name), at)
            return float(round(min(max(shown, low), high), 4))

        slider = self.gui.add_slider(label, float(low), float(high), float(step), value())
        self._read.append(lambda: _assign(slider, value()))
        self._sliders.setdefault(name, []).append((slider, value))

        def moved(event: Any) -> None:
            if event.client is None:  # brought there by `show`
                return
            with self._lock:
                number = float(slider.value) / factor
                now = getattr(self.knobs, name)
                if name in ("offset", "amplitude") and len(now) > 1 and self.tied.value:
                    self._set(event, **{name: (number,) * len(now)})
                    # Those alone: others may have been moved meanwhile and not have told yet.
                    for other, stands in self._sliders[name]:
                        if other is not slider:
                            _assign(other, stands())
                else:
                    self._set(event, **{name: _with(now, at, number)})

        slider.on_update(moved)
        return slider

    def _set(self, event: Any, **changes: Any) -> None:
        if event.client is None:
            return
        with self._lock:
            self.knobs = replace(self.knobs, **changes)
            self._turned(self.knobs)

    def _tie(self) -> None:
        for slider in self._others:
            slider.visible = not self.tied.value

    def _choose(self, event: Any) -> None:
        found = (presets(self.robot) | self._offered).get(self._preset.value)
        if event.client is None or found is None:
            return
        still = tuple((0.0,) * self.robot.n_legs for _ in OVERTONES)
        knobs = replace(self.knobs, overtone=still, overtone_phase=still, **found)
        self._untie(knobs)
        self.show(knobs)
        self._turned(knobs)


def presets(robot: Robot) -> dict[str, dict[str, Any]]:
    """Gaits by name: entries of the knobs."""
    n = robot.n_legs
    quarter = tuple(0.5 * math.pi * (k % 2) for k in range(n))
    found: dict[str, dict[str, Any]] = {}
    if n == 2:
        for name in ("lateral", "circular"):
            legs = named_gait(name)
            found[f"{name} (paper)"] = {
                "offset": tuple(legs.offset.tolist()),
                "amplitude": tuple(legs.amplitude.tolist()),
                "phase": tuple(legs.phase.tolist()),
                "frequency": float(legs.angular_frequency[0]),
            }
        found["forward, legs opposed"] = {
            "offset": (0.0, 0.0), "amplitude": (0.4, 0.4), "phase": (0.0, math.pi),
            "frequency": 8.0,
        }  # fmt: skip
    if n:
        found["one leg"] = {
            "amplitude": (0.3, *(0.0,) * (n - 1)), "phase": quarter, "frequency": 8.0,
        }  # fmt: skip
        found["all in step"] = {"phase": (0.0,) * n}
        found["in quarter turns"] = {"phase": quarter}
    return found


def numbers(outcome: Outcome | None, refusal: str | None, *, waiting: bool = False) -> str:
    """The numbers of a motion, and what is to be said, as HTML."""
    if waiting:
        refusal = "Computing; the first run of a kind compiles the engine, a minute or two."
    rows = "" if outcome is None else "".join(
        f"<tr><td>{name}</td><td><b>{value}</b></td></tr>"
        for name, value in _rows(outcome).items()
    )  # fmt: skip
    words = [] if outcome is None or refusal is not None else list(outcome.words)
    told = "".join(
        f'<p style="margin:.3em 0;color:#8a5a00">{html.escape(word)}</p>' for word in words
    )
    if refusal is not None:
        kept = "" if outcome is None or waiting else " The last good path is kept."
        told = (
            f'<p class="rr-refusal" style="margin:.3em 0;color:#b00020"><b>'
            f"{html.escape(refusal)}</b>{kept}</p>"
        )
    grey = "opacity:.45;" if refusal is not None else ""
    data = "" if outcome is None else "".join(
        f' data-{key}="{value!r}"' for key, value in _data(outcome).items()
    )  # fmt: skip
    return (
        f'<div class="rr-numbers" style="font-size:13px;padding:.4em .8em"{data}>{told}'
        f'<table style="{grey}">{rows}</table></div>'
    )


def _data(outcome: Outcome) -> dict[str, float]:
    end = outcome.end()
    return {
        "speed": float(outcome.speed), "yaw-rate": float(outcome.yaw_rate),
        "friction": float(outcome.friction), "normal-force": float(outcome.normal_force),
        "torque": float(outcome.torque), "end-x": float(end[0]), "end-y": float(end[1]),
        "settled": float(outcome.settled),
    }  # fmt: skip


def _rows(outcome: Outcome) -> dict[str, str]:
    mean = "" if outcome.settled else " (mean)"
    curvature, torque = outcome.curvature, outcome.torque
    turns = abs(curvature) >= _STRAIGHT
    if math.isinf(curvature):
        turning = "on the spot"
    elif not turns:
        turning = "straight"
    else:
        radius = 1 / abs(curvature)
        wide = f"{radius:.4g} m" if radius >= 1 else f"{1e3 * radius:.4g} mm"
        turning = f"{curvature:.4g} /m, radius {wide}"
    slips = ", <i>slips</i>" if outcome.friction > outcome.knobs.friction else ""
    rows = {
        f"speed{mean}": f"{1e3 * outcome.speed:.4g} mm/s",
        f"yaw rate{mean}": f"{_DEG * outcome.yaw_rate if turns else 0.0:.4g} °/s",
        "curvature": turning,
        "friction needed": f"{outcome.friction:.3g} of {outcome.knobs.friction:.3g}{slips}",
        "least normal force": f"{outcome.normal_force:.3g} N",
        "peak torque": f"{torque:.3g} N m" if torque >= 1 else f"{1e3 * torque:.3g} mN m",
    }
    if outcome.cycle is not None and outcome.multipliers.size:
        largest = abs(outcome.multipliers[0])
        if largest < 1:
            times = outcome.cycle.settling_times
            rows["stability"] = f"settles in {float(np.max(times)):.3g} s (|μ| {largest:.3f})"
        else:
            rows["stability"] = f"unstable (|μ| {largest:.3f})"
    else:
        rows["stability"] = "-" if outcome.settled else "not settled"
    return rows


def _alike(knobs: Knobs) -> bool:
    """Whether all legs have the same offset and the same amplitude."""
    return len(set(knobs.offset)) <= 1 and len(set(knobs.amplitude)) <= 1


def _entry(value: Any, at: Any) -> float:
    if at is None:
        return float(value)
    return float(value[at[0]][at[1]] if isinstance(at, tuple) else value[at])


def _with(value: Any, at: Any, number: float) -> Any:
    """The same tuple with one number changed."""
    if at is None:
        return number
    if isinstance(at, tuple):
        row, k = at
        return tuple(_with(part, k, number) if i == row else part for i, part in enumerate(value))
    return tuple(number if i == at else part for i, part in enumerate(value))


def _assign(control: Any, value: Any) -> None:
    if control.value != value:
        control.value = value
