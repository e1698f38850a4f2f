"""Films as .mp4 and .gif, and pictures of them as .png: frames of Meshcat's page in Chromium."""

from __future__ import annotations

import io
import math
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rrrobot.errors import MissingExtraError, OutputError, ParameterError
from rrrobot.integrate import Progress
from rrrobot.view.chromium import Browser

Size = tuple[int, int]
Pixels = NDArray[np.uint8]

_LARGEST = 4096


def checked_size(size: Any) -> Size:
    """Width and height of a film [px], even as video demands."""
    try:
        wide, high = (int(part) for part in size)
        whole = (wide, high) == tuple(size)
    except (TypeError, ValueError):
        wide = high = 0
        whole = False
    if not (whole and all(16 <= n <= _LARGEST and n % 2 == 0 for n in (wide, high))):
        raise ParameterError(
            f"size is {size!r}: it must be a width and a height, even numbers from 16 to "
            f"{_LARGEST} px, such as (1280, 720)."
        )
    return wide, high


def frames(
    page: bytes, size: Size, times: Sequence[float], *, progress: Progress | None = None
) -> Iterator[Pixels]:
    """Pictures (height, width, 3) of a film's page at times of the film [s]."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "film.html")
        path.write_bytes(page)
        with Browser(size, timeout=120.0) as browser:
            browser.open(path.as_uri())
            browser.run("page.hold(true)")
            for time in times:
                browser.seek(time)
                yield browser.picture().astype(np.uint8)
                if progress is not None:
                    progress(time)


def video(pictures: Iterator[Pixels], size: Size, fps: float) -> bytes:
    """An .mp4 (H.264) of the pictures.

    Raises:
        MissingExtraError: imageio-ffmpeg is not installed.
        OutputError: ffmpeg failed.
    """
    try:
        import imageio_ffmpeg
    except ImportError:
        raise MissingExtraError(
            "an .mp4 needs ffmpeg: pip install imageio-ffmpeg, which the extra 'media' brings; "
            ".gif, .png and .html need none."
        ) from None
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "film.mp4")
        writer = imageio_ffmpeg.write_frames(
            str(path), size, fps=fps, quality=7, macro_block_size=2, ffmpeg_log_level="error"
        )
        writer.send(None)
        try:
            for picture in pictures:
                writer.send(np.ascontiguousarray(picture))
        except OSError as error:
            raise OutputError(f"ffmpeg could not write the film: {error}.") from None
        finally:
            writer.close()
        return path.read_bytes()


def gif(pictures: Iterator[Pixels], fps: float) -> bytes:
    """A .gif of the pictures that plays again and again; its clock has hundredths of a second."""
    from PIL import Image

    made = [
        Image.fromarray(picture).convert("P", palette=Image.Palette.ADAPTIVE, colors=128)
        for picture in pictures
    ]
    stream = io.BytesIO()
    made[0].save(
        stream, "GIF", save_all=True, append_images=made[1:], loop=0,
        duration=10 * max(2, round(100 / fps)), optimize=False,
    )  # fmt: skip
    return stream.getvalue()


def strip(pictures: Iterator[Pixels]) -> bytes:
    """A .png of the pictures side by side."""
    from PIL import Image

    stream = io.BytesIO()
    Image.fromarray(np.concatenate(list(pictures), axis=1)).save(stream, "PNG", optimize=True)
    return stream.getvalue()


def film_times(duration: float, fps: float) -> list[float]:
    """Times of the frames of a film [s]."""
    return [k / fps for k in range(max(1, math.floor(duration * fps + 1e-6) + 1))]
