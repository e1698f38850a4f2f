"""`rrrobot machines`: other machines of legless locomotion and rolling, listed and simulated."""

from __future__ import annotations

from typing import Any

import click
import numpy as np

from rrrobot.cli.report import tell
from rrrobot.cli.types import NUMBER
from rrrobot.errors import ModelError, ParameterError
from rrrobot.inline import aligned
from rrrobot.machines.catalog import MACHINES, by_name
from rrrobot.machines.history import History
from rrrobot.machines.machine import Machine
from rrrobot.machines.reduced import Reduction
from rrrobot.view.films import record


@click.command("machines")
@click.argument("name", required=False)
@click.option(
    "--gait", help="One of the machine's; its first unless given, and none if it has none."
)
@click.option("--duration", type=NUMBER, help="[s]; one period of the gait, or 5 s, unless given.")
@click.option(
    "--set", "settings", multiple=True, metavar="KEY=VALUE", help="A parameter, as m=5.0; repeat."
)
@click.option("--film", metavar="FILE", help="Write a film: .html, .mp4, .gif or .png.")
@click.option("--urdf", is_flag=True, help="Print the machine's URDF and do nothing else.")
@click.option("--json", "as_json", is_flag=True, help="As JSON.")
def machines(
    name: str | None,
    gait: str | None,
    duration: float | None,
    settings: tuple[str, ...],
    film: str | None,
    urdf: bool,
    as_json: bool,
) -> None:
    """List the machines, or simulate one by its name.

    \b
    Examples:
      rrrobot machines
      rrrobot machines snakeboard --gait drive
      rrrobot machines falling_cat --film cat.html
      rrrobot machines rolling_disc --set rho=0.02 --duration 3 --json
    """
    if name is None:
        _list(as_json)
        return
    machine = by_name(name, **_parameters(settings))
    if urdf:
        click.echo(machine.urdf, nl=False)
        return
    if gait is not None and gait not in machine.gaits:
        known = ", ".join(machine.gaits) or "none: it moves by itself"
        raise ModelError(f"the {name} has no gait {gait!r}; it has: {known}.")
    chosen = gait if gait is not None else next(iter(machine.gaits), None)
    drive = None if chosen is None else machine.gaits[chosen]
    if duration is None:
        duration = (drive.period if drive is not None else None) or 5.0
    history = machine.simulate(drive, duration)
    if film is not None:
        record(history, film, axes=False)
    data = {"title": machine.title, "gait": chosen, **history.to_dict()}
    tell(data, _table(machine, chosen, history), (), as_json=as_json)


def _list(as_json: bool) -> None:
    rows, data = [], {}
    for name, make in MACHINES.items():
        machine = make()
        kind = _kind(machine)
        gaits = ", ".join(machine.gaits) or "moves by itself"
        rows.append((name, f"{machine.title}; {kind}; {gaits}"))
        data[name] = {
            "title": machine.title,
            "kind": kind,
            "gaits": list(machine.gaits),
            "motors": list(machine.model.motors),
            "parameters": list(make.__kwdefaults__ or {}),
        }
    tell({"machines": data}, aligned(rows), (), as_json=as_json)


def _kind(machine: Machine) -> str:
    """How its shape moves it, by computation."""
    try:
        reduction = Reduction(machine)
    except ModelError:
        return "drift" if machine.model.n_shape else "free motion"
    return f"{reduction.kind}, {reduction.group}"


def _table(machine: Machine, gait: str | None, t: History) -> str:
    def numbers(values: Any) -> str:
        return ", ".join(f"{x:.9g}" for x in np.atleast_1d(values))

    labels = "x, y, theta" if machine.model.planar else "position, quaternion xyzw"
    rows = [
        ("machine", machine.title),
        ("gait", gait or "none"),
        ("duration", f"{t.time[-1]:.6g} s, {len(t)} samples"),
        (f"pose at the end ({labels})", numbers(t.pose[-1])),
        ("body velocity at the end", numbers(t.body_velocity[-1])),
        ("energy", f"{t.energy.min():.6g} .. {t.energy.max():.6g} J"),
        ("constraints broken by", f"{t.violation.max():.1e}"),
    ]
    if machine.model.motors:
        torque = t.joint_torques
        rows.append(("motor torques", f"{torque.min():.4g} .. {torque.max():.4g} N m"))
    return aligned(rows)


def _parameters(settings: tuple[str, ...]) -> dict[str, float]:
    found = {}
    for setting in settings:
        key, equals, value = setting.partition("=")
        try:
            found[key] = float(value)
        except ValueError:
            equals = ""
        if not equals:
            raise ParameterError(f"--set is {setting!r}: it must be KEY=VALUE, a number, as m=5.0.")
    return found
