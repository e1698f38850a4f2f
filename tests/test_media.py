"""Films as .mp4, .gif and .png."""

import io
import subprocess
import sys

import numpy as np
import pytest
from PIL import Image

import rrrobot as rr
from rrrobot.view.frames import film_times, gif, strip
from tests.browser import find_browser
from tests.test_cli import assert_refused, run

SIZE = (160, 90)
needs_browser = pytest.mark.skipif(find_browser() is None, reason="no Chromium or Chrome")


@pytest.fixture(scope="module")
def trajectory():
    return rr.simulate(rr.FullModel(rr.Robot.from_parameters()), rr.gait("circular"), 1.0)


@pytest.mark.slow
@needs_browser
def test_a_video_shows_at_each_time_what_the_page_shows(trajectory, tmp_path):
    ffmpeg = pytest.importorskip("imageio_ffmpeg")
    seen = []
    options = {"size": SIZE, "caption": False, "trace": "whole"}

    def told(done, _):
        seen.append(done)

    film = rr.record(trajectory, tmp_path / "film.mp4", fps=4, progress=told, **options)
    assert seen == [0.0, 0.25, 0.5, 0.75, 1.0]
    wide, high = SIZE
    command = (ffmpeg.get_ffmpeg_exe(), "-i", film, "-f", "rawvideo", "-pix_fmt", "rgb24", "-")
    read = subprocess.run(command, capture_output=True, check=True)
    assert f"{wide}x{high}" in read.stderr.decode() and "4 fps" in read.stderr.decode()
    shown = np.frombuffer(read.stdout, np.uint8).reshape(-1, high, wide, 3).astype(int)
    assert len(shown) == 5
    # Another way to the same instants; a video's colours are compressed.
    path = rr.record(trajectory, tmp_path / "strip.png", at=(0.0, 0.5, 1.0), **options)
    pages = np.split(np.asarray(Image.open(path).convert("RGB"), dtype=int), 3, axis=1)
    away = np.array([[np.abs(frame - page).mean() for page in pages] for frame in shown[::2]])
    assert np.all(np.diag(away) < 7.5)
    # Each frame is nearest to its own instant.
    assert away.argmin(axis=1).tolist() == [0, 1, 2]


def test_a_gif_and_a_strip_hold_their_pictures():
    pictures = [np.full((20, 30, 3), (60 * k, 0, 255 - 60 * k), np.uint8) for k in range(3)]
    made = Image.open(io.BytesIO(gif(iter(pictures), 10.0)))
    assert made.n_frames == 3 and made.size == (30, 20) and made.info["duration"] == 100
    for k, picture in enumerate(pictures):
        made.seek(k)
        assert np.abs(np.asarray(made.convert("RGB"), dtype=int) - picture).max() <= 3
    row = np.asarray(Image.open(io.BytesIO(strip(iter(pictures)))))
    assert row.shape == (20, 90, 3) and row[0, 45].tolist() == [60, 0, 195]
    assert film_times(1.0, 4.0) == [0.0, 0.25, 0.5, 0.75, 1.0] and film_times(0.0, 30.0) == [0.0]


def test_bad_input_is_refused_before_anything_is_drawn(trajectory, tmp_path, monkeypatch):
    def refused(error, match, name="x.mp4", **options):
        with pytest.raises(error, match=match):
            rr.record(trajectory, tmp_path / name, **options)
        assert not list(tmp_path.iterdir())

    refused(rr.OutputError, "ends in", "x.avi")
    refused(rr.ParameterError, "size is", size=(641, 360))
    refused(rr.ParameterError, "size is", size="big")
    refused(rr.ParameterError, "at would do nothing", at=0.5)
    refused(rr.ParameterError, r"lie between 0 and 1 s", "x.png", at=(0.5, 1.5))
    refused(rr.ParameterError, "camera is", camera=(0.0, 0.0, 0.01))
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    refused(rr.MissingExtraError, "pip install")
    monkeypatch.setenv("PATH", str(tmp_path))
    refused(rr.OutputError, "no Chromium", "x.gif")


def test_the_command_line_refuses_what_cannot_be(tmp_path):
    film = str(tmp_path / "x.mp4")
    assert_refused(run("view", "--film", str(tmp_path / "x.txt")), "--film ends in")
    found = run("view", "--film", film, "--size", "wide")
    assert found.exit_code == 2
    assert "write it as 1280x720" in found.stderr
