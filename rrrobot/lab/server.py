"""The laboratory's page, served to this computer alone."""

from __future__ import annotations

import contextlib
import importlib.util
import io
import socket
import threading
import warnings
import webbrowser
from typing import Any

from rrrobot.belly.found import Belly
from rrrobot.errors import MissingExtraError, ModelError, OutputError, ParameterError
from rrrobot.lab.bellies import begin, check_belly
from rrrobot.lab.knobs import Knobs
from rrrobot.lab.outcome import Outcome, Refusal, settle
from rrrobot.lab.panel import numbers
from rrrobot.lab.session import Session
from rrrobot.robot.robot import Robot

LOOPBACK = "127.0.0.1"


class Laboratory:
    """A page on which every move of a slider redraws the robot's path; see `laboratory`.

    Attributes:
        robot: the robot.
        belly: its fitted belly, if it was opened with one.
        url: address of the page; only this computer can open it.
        sessions: one for each open page, by viser's number of it.
    """

    def __init__(self, robot: Robot | Belly, *, port: int | None = None) -> None:
        belly = robot if isinstance(robot, Belly) else None
        if isinstance(robot, Belly):
            check_belly(robot)
            robot = robot.robot
        if not isinstance(robot, Robot):
            raise ModelError(
                f"robot is {type(robot).__name__}: it must be a Robot, such as "
                "Robot.from_parameters(), or what fit_belly finds."
            )
        if not robot.n_legs:
            raise ModelError(
                f"{robot.name} has no legs that move: the laboratory is for robots with legs; "
                "name some with legs=."
            )
        if port is not None and not (type(port) is int and 0 < port < 65536):
            raise ParameterError(f"port is {port!r}: it must be an integer from 1 to 65535.")
        if importlib.util.find_spec("viser") is None:
            raise MissingExtraError(
                "the laboratory needs viser: pip install 'rrrobot[lab]', or pip install viser."
            )
        # RRRobot's belly is its shell, which the sliders change.
        self.belly = None if robot.parameters is not None else belly
        self.robot, self._knobs = robot, Knobs.of(robot)
        self.sessions: dict[int, Session] = {}
        self._lock = threading.Lock()
        self._first: Outcome | None = None
        # Numba loads the engine meanwhile, so that the page has its first path at once.
        self._warm = threading.Thread(target=self._warm_up, name="rrrobot lab", daemon=True)
        self._warm.start()
        self._server = _serve(_free_port(port), f"rrrobot laboratory: {robot.name}")
        self.url = f"http://{LOOPBACK}:{self._server.get_port()}/"
        self._server.on_client_connect(self._opened)
        self._server.on_client_disconnect(self._left)

    def close(self) -> None:
        """Stop serving the page; closing again does nothing."""
        with self._lock:
            sessions, self.sessions = self.sessions, {}
        for session in sessions.values():
            session.close()
        server, self._server = self._server, None
        if server is not None:
            with contextlib.redirect_stdout(io.StringIO()):
                server.stop()

    def wait(self) -> None:
        """Serve until Ctrl-C."""
        threading.Event().wait()

    def _warm_up(self) -> None:
        if self.belly is not None:
            self._knobs, self._first = begin(self.belly)
            return
        with contextlib.suppress(Refusal):
            self._first = settle(self.robot, self._knobs)

    def _opened(self, client: Any) -> None:
        if self.belly is not None and self._warm.is_alive():
            note = client.gui.add_html(numbers(None, None, waiting=True))
            self._warm.join()
            note.remove()
        session = Session(client, self.robot, self._knobs, self.url, self._first, self.belly)
        with self._lock:
            self.sessions[client.client_id] = session
            server = self._server
        if server is None or client.client_id not in server.get_clients():
            self._left(client)  # while it waited

    def _left(self, client: Any) -> None:
        with self._lock:
            session = self.sessions.pop(client.client_id, None)
        if session is not None:
            session.close()

    def __enter__(self) -> Laboratory:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _repr_html_(self) -> str:
        return (
            f'<iframe src="{self.url}" style="width:100%;height:640px;border:0" '
            "allowfullscreen></iframe>"
        )

    def __repr__(self) -> str:
        return f"Laboratory({self.robot.name!r}, url={self.url!r})"


def laboratory(
    robot: Robot | Belly, *, port: int | None = None, open_browser: bool = False
) -> Laboratory:
    """Open the laboratory: a page on which a gait is under your hands.

    Every move of a slider redraws the whole settled path, and the robot rolls along it. The page is
    served on the loopback interface, so only this computer can open it, and is gone when it is
    closed or the script ends. As the last line of a notebook's cell it shows inline.

    Args:
        robot: any robot with legs; or its `Belly` as `fit_belly` finds it, on which the page has
            it rest, with its legs clear of the ground, and says what they run into.
        port: of the page; any free one if None.
        open_browser: whether to open the page in the default browser.

    Raises:
        MissingExtraError: viser is not installed (extra `lab`).
        OutputError: the port is taken.
        ParameterError: the port is out of range.
        ModelError: the robot has no legs; a belly that was fitted on other than level ground.

    Example:
        >>> import rrrobot as rr
        >>> with rr.laboratory(rr.Robot.from_parameters()) as lab:  # doctest: +SKIP
        ...     print(lab.url)
        http://127.0.0.1:8080/
    """
    lab = Laboratory(robot, port=port)
    if open_browser:
        webbrowser.open(lab.url)
    return lab


def _free_port(port: int | None) -> int:
    """That port, or any free one. Viser would take the next free one and not say so."""
    try:
        with socket.create_server((LOOPBACK, port or 0)) as probe:
            return int(probe.getsockname()[1])
    except OSError as error:
        raise OutputError(
            f"cannot serve the laboratory on port {port}: {error}. Name another port, or none."
        ) from None


def _serve(port: int, title: str) -> Any:
    import viser

    # Of a page that is left while its robot is being drawn, which harms nobody.
    warnings.filterwarnings("ignore", "Queued a .* on a closed connection", UserWarning)
    # Viser prints a banner.
    with contextlib.redirect_stdout(io.StringIO()):
        server = viser.ViserServer(host=LOOPBACK, port=port, label=title, verbose=False)
    if server.get_port() != port:
        server.stop()
        raise OutputError(f"port {port} was taken meanwhile: try again.")
    return server
