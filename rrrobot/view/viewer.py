"""Meshcat viewer: `Viewer` shows a robot in a browser while a script runs.

Only this computer can open its page. Films that need neither are in `films.py`.
"""

from __future__ import annotations

import time
import webbrowser

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from rrrobot.checks import Array, vector
from rrrobot.contact.ground import Ground, Plane
from rrrobot.errors import ModelError, ParameterError
from rrrobot.robot.robot import Robot
from rrrobot.simulation.trajectory import Trajectory
from rrrobot.view.film import Film, make_film, thin
from rrrobot.view.scene import Pose, Scene
from rrrobot.view.server import SceneServer

_PIECE = 100  # points of the live trace that are sent together


class Viewer:
    """A robot in a browser, live.

    The page is served on the loopback interface, so only this computer can open it, and is gone
    when the viewer is closed or the script ends.

    Args:
        robot: the robot to show, at first at its neutral configuration.
        ground: what it stands on; level ground unless given.
        open_browser: whether to open the page in the default browser.
        port: of the page; any free one if None.
        trace: whether to draw the contact point's path.
        axes: whether to draw the axes of the world and of the shell: x red, y green, z blue.
        follow: whether the camera goes with the robot.

    Attributes:
        robot: the robot.
        url: address of the page.

    Raises:
        ParameterError: the port is out of range.
        OutputError: the port is taken.

    Example:
        >>> import pinocchio as pin, rrrobot as rr
        >>> from rrrobot.view.viewer import Viewer
        >>> robot = rr.Robot.from_parameters()
        >>> with Viewer(robot) as viewer:
        ...     viewer.show(pin.neutral(robot.model))
        ...     viewer.url.startswith("http://127.0.0.1:")
        True
    """

    def __init__(
        self,
        robot: Robot,
        *,
        ground: Ground | None = None,
        open_browser: bool = False,
        port: int | None = None,
        trace: bool = True,
        axes: bool = True,
        follow: bool = False,
    ) -> None:
        if port is not None and not (type(port) is int and 0 < port < 65536):
            raise ParameterError(f"port is {port!r}: it must be an integer from 1 to 65535.")
        self.robot = robot
        self.ground = Plane() if ground is None else ground
        self._trace, self._follow = trace, follow
        self._scene = Scene(robot, self.ground)
        self._server = SceneServer(robot.name, port)
        self.url = self._server.url
        pose = self._scene.rest()
        self._pieces, self._piece = 0, np.empty((0, 2))
        self._server.send(self._scene.objects(axes=axes))
        self._frame(pose.center[None])
        self._server.send(self._scene.place(pose))
        if open_browser:
            webbrowser.open(self.url)

    def show(self, configuration: ArrayLike) -> None:
        """Show the robot at a configuration, and draw the contact point's path on from the last.

        Args:
            configuration: free-flyer q of `robot.model` (nq,), such as a row of
                `Trajectory.configuration`.

        Raises:
            ParameterError: it has the wrong size or a value that is not finite.
            OutputError: the viewer is closed.
        """
        model = self.robot.model
        q = vector("configuration", configuration, model.nq)
        if not np.linalg.norm(q[3:7]) > 0:
            raise ParameterError("configuration has a zero quaternion (entries 3 to 6).")
        pose = self._scene.pose(pin.normalize(model, q))
        self._draw(pose, pose.contact[None])

    def play(
        self, trajectory: Trajectory, *, speed: float = 1.0, loop: bool = False, fps: float = 60.0
    ) -> None:
        """Play a trajectory at its pace; frames are dropped where the computer lags.

        Args:
            trajectory: of this viewer's robot.
            speed: simulated seconds per second.
            loop: whether to play again and again, until Ctrl-C.
            fps: frames per second, at most [1/s].

        Raises:
            ModelError: the trajectory is another robot's.
            ParameterError: speed or fps out of range.
            OutputError: the viewer is closed.
        """
        if trajectory.robot != self.robot:
            raise ModelError(
                f"the trajectory is of {trajectory.robot!r}, the viewer of {self.robot!r}: make "
                "a Viewer of the trajectory's robot."
            )
        if trajectory.ground != self.ground:
            raise ModelError(
                f"the trajectory is on {trajectory.ground!r}, the viewer shows {self.ground!r}: "
                "make a Viewer(robot, ground=trajectory.ground)."
            )
        film = make_film(trajectory, fps=fps, speed=speed, detail=self._scene.detail)
        poses = [
            self._scene.pose(q) for q in film.configuration[:: 1 + len(film.configuration) // 500]
        ]
        self._scene.hold(poses)
        self._frame(np.array([pose.center for pose in poses]))
        self._play_once(film)
        while loop:
            self._play_once(film)

    def show_axes(self, visible: bool = True) -> None:
        """Show or hide the axes."""
        self._server.send(self._scene.axes(visible))

    def clear_trace(self) -> None:
        """Take away the contact point's path; the next starts where the robot is shown next."""
        self._server.delete("/world/ground/trace")
        self._pieces, self._piece = 0, np.empty((0, 2))

    def wait_for_browser(self, timeout: float | None = None) -> bool:
        """Wait until a browser has opened the page.

        Args:
            timeout: longest wait [s]; without end if None.

        Returns:
            whether one has.
        """
        return self._server.wait(timeout)

    def close(self) -> None:
        """Stop serving the page; closing again does nothing."""
        self._server.close()

    def __enter__(self) -> Viewer:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"Viewer({self.robot.name!r}, url={self.url!r})"

    def _play_once(self, film: Film) -> None:
        self.clear_trace()
        start, frame, last = time.monotonic(), -1, len(film.configuration) - 1
        passed = 0
        while frame < last:
            due = min(int((time.monotonic() - start) * film.fps), last)
            if due > frame:
                frame = due
                reached = int(film.reached[frame])
                self._draw(self._scene.pose(film.configuration[frame]), film.path[passed:reached])
                passed = reached
            time.sleep(max(0.0, start + (frame + 1) / film.fps - time.monotonic()))

    def _draw(self, pose: Pose, contacts: Array) -> None:
        commands = self._scene.place(pose)
        if self._follow:
            commands.append(self._scene.look_at(pose.center))
        self._server.send(commands)
        if self._trace and len(contacts):
            self._extend_trace(contacts)
        if np.linalg.norm(pose.center - self._visited.mean(axis=0)) > self._wide:
            self._stage(np.vstack((self._visited, pose.center)))

    def _extend_trace(self, contacts: Array) -> None:
        """Draw on. Only the last piece is sent anew, however long the path becomes."""
        piece = np.vstack((self._piece, contacts))
        piece = piece[thin(piece, self._scene.detail)]
        if len(piece) > max(len(self._piece), 1):
            path = f"/world/ground/trace/{self._pieces}"
            self._server.send([self._scene.trace(piece, self._view, path)])
        self._piece = piece
        if len(piece) > _PIECE:
            self._pieces, self._piece = self._pieces + 1, piece[-1:]

    def _frame(self, centers: Array) -> None:
        """Put the camera where it sees all these places, or the first if it follows the robot."""
        self._view = self._scene.view(centers, follow=self._follow)
        self._server.send(self._scene.camera(self._view))
        self._stage(centers)

    def _stage(self, centers: Array) -> None:
        """Ground and light for the places that the robot visits, with room to spare."""
        low, high = centers.min(axis=0), centers.max(axis=0)
        self._visited = np.vstack((low, high))
        self._wide = float(np.linalg.norm(high - low)) + 2 * self._scene.reach
        self._server.send(self._scene.stage(self._visited, self._view))
