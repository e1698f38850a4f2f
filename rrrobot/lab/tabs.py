"""The tabs of other motions and of what is taken home, of one client."""

from __future__ import annotations

import html
import math
from collections.abc import Callable
from typing import Any, Protocol

import numpy as np

from rrrobot.checks import Array
from rrrobot.lab.atlas import numbers_in
from rrrobot.lab.excursions import driven, pushed, rocking, sent
from rrrobot.lab.home import FILES, code
from rrrobot.lab.knobs import Knobs
from rrrobot.lab.outcome import Outcome
from rrrobot.robot.robot import Robot

_RAD = math.pi / 180
_LINK = "lab"
_READ_LINK = (
    "<img src='data:,' style='display:none' onerror=\"const s=new URLSearchParams(location.search)"
    f".get('{_LINK}');if(s){{const f=this.parentElement.nextElementSibling.querySelector('input');"
    "Object.getOwnPropertyDescriptor(HTMLInputElement.prototype,'value').set.call(f,location.href);"
    "f.dispatchEvent(new Event('input',{bubbles:true}))}\">"
)
"""A page opened by a link writes it into the field that follows, as a person would."""


class Desk(Protocol):
    """What the tabs need of a session."""

    client: Any
    robot: Robot
    knobs: Knobs
    outcome: Outcome | None

    def ask(self, job: Callable[[], Outcome]) -> None:
        """Show what a job comes to."""

    def overtaken(self) -> bool:
        """Whether something else has been asked for meanwhile."""

    def choose(self, knobs: Knobs) -> None:
        """Set all sliders."""

    def keep(self, path: Array | None) -> None:
        """Keep a path beside those that come, or forget it."""

    def say(self, words: str) -> None:
        """Tell the person."""


def motions_tab(gui: Any, desk: Desk) -> None:
    """Compare, push, rock, drive by torques, go there."""
    robot = desk.robot
    with gui.add_folder("compare"):
        kept = gui.add_html("")
        keep = gui.add_button("keep this path")
        forget = gui.add_button("forget it")

    def keep_it(event: Any) -> None:
        o = desk.outcome
        if o is not None:
            desk.keep(o.path())
            kept.content = (
                '<p class="rr-kept" style="margin:.3em .8em;font-size:13px">grey: '
                f"{1e3 * o.speed:.4g} mm/s, {o.yaw_rate / _RAD:.4g} °/s, friction "
                f"{o.friction:.3g}, torque {1e3 * o.torque:.3g} mN m</p>"
            )

    def forget_it(event: Any) -> None:
        desk.keep(None)
        kept.content = ""

    keep.on_click(keep_it)
    forget.on_click(forget_it)

    def button(label: str, job: Callable[[Outcome], Outcome]) -> None:
        pressed = gui.add_button(label)

        def act(event: Any) -> None:
            now = desk.outcome
            if now is not None:
                desk.ask(lambda: job(now))

        pressed.on_click(act)

    with gui.add_folder("push"):
        push = [gui.add_slider(f"{axis} [deg/s]", -200.0, 200.0, 1.0, start)
                for axis, start in (("roll", 40.0), ("pitch", 0.0), ("yaw", 0.0))]  # fmt: skip
        button("push", lambda o: pushed(robot, o, [_RAD * s.value for s in push]))
    with gui.add_folder("rock freely"):
        tilt = [gui.add_slider(f"{axis} [deg]", -60.0, 60.0, 0.5, 15.0)
                for axis in ("roll", "pitch")]  # fmt: skip
        button("let go", lambda o: rocking(robot, desk.knobs, [_RAD * s.value for s in tilt]))
    with gui.add_folder("drive by torques"):
        stiff = gui.add_slider("stiffness [N m/rad]", 0.0, 5.0, 0.01, 1.0)
        damp = gui.add_slider("damping [N m s/rad]", 0.0, 0.2, 0.001, 0.03)
        button("drive", lambda o: driven(
            robot, desk.knobs, stiff.value, damp.value, desk.overtaken
        ))  # fmt: skip
    if robot.n_legs == 2:
        with gui.add_folder("go there"):
            _go_there(gui, desk, button)
    back = gui.add_button("back to the settled motion")
    back.on_click(lambda event: desk.choose(desk.knobs))


def _go_there(gui: Any, desk: Desk, button: Callable[..., None]) -> None:
    goal = gui.add_text("x, y, heading", "0.2, 0.1, 90", hint="In m, m and degrees.")
    pick = gui.add_button("click on the ground")
    scene = desk.client.scene

    def clicked(event: Any) -> None:
        scene.remove_click_callback(clicked)
        place = on_ground(event.ray_origin, event.ray_direction)
        numbers = numbers_in(goal.value, 3) or (0.0, 0.0, 0.0)
        if place is not None:
            goal.value = f"{place[0]:.3f}, {place[1]:.3f}, {numbers[2]:g}"

    pick.on_click(lambda event: scene.on_click()(clicked))

    def go(now: Outcome) -> Outcome:
        numbers = numbers_in(goal.value, 3)
        if numbers is None:
            desk.say("Write the goal as three numbers, such as 0.2, 0.1, 90.")
            return now
        x, y, heading = numbers
        return sent(desk.robot, desk.knobs, (x, y, _RAD * heading))

    button("plan and drive", go)


def on_ground(origin: Any, direction: Any) -> Array | None:
    """Where a ray meets level ground (2,) [m], or None."""
    o, d = np.asarray(origin, dtype=float), np.asarray(direction, dtype=float)
    if d[2] > -1e-9 or o[2] <= 0:
        return None
    return np.asarray(o - o[2] / d[2] * d)[:2]


def home_tab(gui: Any, desk: Desk) -> None:
    """Code, files and a picture."""

    def show_code(event: Any) -> None:
        text = code(desk.robot, desk.knobs)
        with gui.add_modal("This motion as Python") as modal:
            gui.add_html(
                '<pre class="rr-code" style="font-size:12px;overflow:auto;margin:0" '
                f'>{html.escape(text)}</pre><button onclick="navigator.clipboard.writeText('
                'this.previousElementSibling.innerText)">copy</button>'
            )
            gui.add_button("close").on_click(lambda event: modal.close())

    gui.add_button("Python code").on_click(show_code)
    for label, (name, make) in FILES.items():
        gui.add_button(label).on_click(_saver(desk, name, make))

    def picture(event: Any) -> None:
        pixels = desk.client.get_render(720, 1280, transport_format="png", timeout=30.0)
        desk.client.send_file_download("laboratory.png", _png(pixels), save_immediately=True)

    gui.add_button("picture (.png)").on_click(picture)


def link_field(gui: Any, desk: Desk, url: str) -> Callable[[Knobs], None]:
    """The field of the link, below all tabs; gives the function that writes that of new knobs."""
    gui.add_html(_READ_LINK)
    link = gui.add_text("link", "", hint="Opens the laboratory in the same state; paste one here.")

    def follow(event: Any) -> None:
        if event.client is None:
            return
        text = link.value.partition(f"{_LINK}=")[2].partition("&")[0]
        if text:
            desk.choose(desk.knobs.read(text))

    link.on_update(lambda event: _told(desk, follow, event))

    def write(knobs: Knobs) -> None:
        link.value = f"{url}?{_LINK}={knobs.text()}"

    return write


def _saver(desk: Desk, name: str, make: Callable[[Outcome], bytes]) -> Callable[[Any], None]:
    def save(event: Any) -> None:
        if desk.outcome is not None:
            desk.client.send_file_download(name, make(desk.outcome), save_immediately=True)

    return lambda event: _told(desk, save, event)


def _told(desk: Desk, act: Callable[[Any], None], event: Any) -> None:
    """Do it, and say what goes wrong."""
    try:
        act(event)
    except Exception as error:
        desk.say(" ".join(str(error).split()))


def _png(pixels: Any) -> bytes:
    import io

    from PIL import Image

    stream = io.BytesIO()
    Image.fromarray(pixels).save(stream, "PNG")
    return stream.getvalue()
