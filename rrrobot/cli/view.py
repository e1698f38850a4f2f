"""`rrrobot view`."""

from __future__ import annotations

import threading
import webbrowser
from typing import Any

import click

from rrrobot.checks import finite
from rrrobot.cli.options.drive import GAITS, GaitName
from rrrobot.cli.simulate import checked_file
from rrrobot.cli.types import NUMBER, Size
from rrrobot.drive.gaits import gait as named_gait
from rrrobot.drive.tables import read_gait
from rrrobot.models.full import FullModel
from rrrobot.robot.robot import Robot
from rrrobot.simulation.run import simulate
from rrrobot.simulation.trajectory import Trajectory


@click.command()
@click.argument("file", required=False, metavar="[FILE.npz]")
@click.option(
    "--gait",
    type=GaitName(*GAITS),
    metavar="|".join((*GAITS, "FILE")),
    default="lateral",
    show_default=True,
    help="Of RRRobot, where no trajectory is given; a FILE of a gait is .json or .csv.",
)
@click.option("--duration", type=NUMBER, default="10", show_default=True, help="Of it [s].")
@click.option(
    "--speed", type=NUMBER, default="1", show_default=True, help="Simulated seconds per second."
)
@click.option("--loop", is_flag=True, help="The page plays again and again; a film always does.")
@click.option("--labels", is_flag=True, help="The legs' names beside them.")
@click.option("--force", is_flag=True, help="The contact's force as an arrow.")
@click.option("--translucent", is_flag=True, help="A shell that lets through what it hides.")
@click.option("--curves", is_flag=True, help="Angles and motor torques beneath; a page has them.")
@click.option("--no-browser", is_flag=True, help="Print the address, open no browser.")
@click.option("--html", metavar="FILE", help="Write the film to this .html instead, and end.")
@click.option(
    "--film", metavar="FILE", help="Write it as .mp4, .gif or .html, or its end as .png, and end."
)
@click.option(
    "--size", type=Size(), default="960x540", show_default=True, help="Of .mp4, .gif and .png [px]."
)
@click.option("--fps", type=NUMBER, default="30", show_default=True, help="Of a film [1/s].")
@click.option("--follow", is_flag=True, help="The camera of a film goes with the robot.")
@click.option("--quiet", is_flag=True, help="No progress bar.")
def view(
    file: str | None,
    gait: str,
    duration: float,
    speed: float,
    loop: bool,
    labels: bool,
    force: bool,
    translucent: bool,
    curves: bool,
    no_browser: bool,
    html: str | None,
    film: str | None,
    size: tuple[int, int],
    fps: float,
    follow: bool,
    quiet: bool,
) -> None:
    """Show a saved trajectory, or a gait of RRRobot, in the browser.

    Prints the address of the page, which only this computer can open, and serves it until Ctrl-C.
    The page has a clock, a speed, play and pause (the space bar), and says what else it can show.

    \b
    Examples:
      rrrobot view --gait circular --loop
      rrrobot view run.npz --speed 0.5
      rrrobot view run.npz --labels --force --html run.html
      rrrobot view --gait circular --film circular.mp4 --size 1280x720
    """
    if html is not None and film is not None:
        raise click.UsageError("give --html or --film, not both.")
    target = None if html is None else checked_file("html", html)
    if film is not None:
        target = checked_file("film", film)
    if file is not None:
        trajectory = Trajectory.load(file)
    else:
        finite("duration", duration, "s", above=0)
        model = FullModel(Robot.from_parameters())
        legs = named_gait(gait) if gait in GAITS else read_gait(gait)
        trajectory = simulate(model, legs, duration, progress=False if quiet else None)
    looks: dict[str, Any] = {
        "speed": speed, "fps": fps, "follow": follow, "labels": labels, "force": force,
        "translucent": translucent, "curves": curves or target is None,
    }  # fmt: skip
    if target is not None:
        from rrrobot.view.films import record

        record(trajectory, target, size=size, progress=False if quiet else None, **looks)
        click.echo(f"wrote {target}")
        return
    _serve(trajectory, open_browser=not no_browser, loop=loop, **looks)


def _serve(trajectory: Trajectory, *, open_browser: bool, **looks: Any) -> None:
    from rrrobot.view.films import film_html
    from rrrobot.view.server import SceneServer

    page = film_html(trajectory, **looks)
    server = SceneServer(trajectory.robot.name, page=page)
    try:
        click.echo(f"{server.url}  (Ctrl-C ends)")
        if open_browser:
            webbrowser.open(server.url)
        threading.Event().wait()
    except KeyboardInterrupt:
        click.echo("closed", err=True)
    finally:
        server.close()
