"""Robot files of other dialects: xacro is expanded or named, SDF and MJCF are named.

xacro is a macro language whose expressions are Python, so it is expanded by the `xacro` or the
`xacrodoc` package (extra `xacro`) in a process of its own, within a time.
"""

from __future__ import annotations

import importlib.util
import subprocess
import sys
from pathlib import Path
from xml.etree.ElementTree import Element

from rrrobot.errors import UrdfError

_SECONDS = 30.0
_EXPAND = """
import sys
source, text = sys.argv[1], sys.stdin.read()
try:
    import xacro
    import xacro.substitution_args
except ImportError:
    from xacrodoc import xacro
if source:
    import os
    os.chdir(os.path.dirname(os.path.abspath(source)))
doc = xacro.parse(text, source or None)
xacro.process_doc(doc)
sys.stdout.write(doc.toxml())
"""
_OTHERS = {
    "sdf": ("an SDF file", "convert it, with `gz sdf` and `sdformat_urdf` for instance"),
    "gazebo": ("an old SDF file", "convert it to SDF 1.6 first, then to URDF"),
    "mujoco": ("an MJCF file of MuJoCo", "convert it, with `mjcf2urdf` for instance"),
    "COLLADA": ("a COLLADA mesh", "name the URDF that shows it"),
    "srdf": ("an SRDF file", "name the URDF that it belongs to"),
}


def name_other_dialects(root: Element) -> None:
    """Refuse a file that is no URDF by its root element, and say what it is.

    Raises:
        UrdfError: the root is not <robot>.
    """
    if root.tag == "robot":
        return
    what, advice = _OTHERS.get(root.tag, ("", ""))
    if what:
        raise UrdfError(f"the file is {what}, not a URDF: {advice}.")
    raise UrdfError(f"the file's root element is <{root.tag[:60]}>: a URDF starts with <robot>.")


def xacro_mark(root: Element) -> tuple[str, int] | None:
    """What shows that a file is xacro and not expanded, and its line; None if nothing does."""
    prefixes = {"xacro"} | {
        key.partition(":")[2]
        for element in root.iter()
        for key, value in element.attrib.items()
        if key.startswith("xmlns:") and "xacro" in value and value.startswith("http")
    }
    for element in root.iter():
        line = getattr(element, "line", 0)
        prefix, colon, _ = element.tag.partition(":")
        if colon and prefix in prefixes:
            return f"<{element.tag[:60]}>", line
        # What expansion leaves of a substitution is its value.
        for key, value in element.attrib.items():
            if "${" in value or "$(" in value:
                return f"<{element.tag[:60]} {key}={value[:40]!r}>", line
    return None


def expand_xacro(text: str, path: Path | None, mark: tuple[str, int]) -> str:
    """The URDF of xacro text.

    Args:
        text: the xacro.
        path: its file, beside which included files are looked up; None if there is none.
        mark: of `xacro_mark`, for the message.

    Raises:
        UrdfError: neither package is installed, or the expansion fails or takes too long.
    """
    what, line = mark
    at = f"{what} at line {line}" if line else what
    if not any(importlib.util.find_spec(name) for name in ("xacro", "xacrodoc")):
        name = path.name if path else "robot.urdf.xacro"
        raise UrdfError(
            f"the file has unexpanded xacro ({at}): run `xacro {name} > robot.urdf` first, or "
            "pip install 'rrrobot[xacro]', and it is expanded here."
        )
    try:
        done = subprocess.run(
            [sys.executable, "-c", _EXPAND, str(path or "")],
            input=text, capture_output=True, text=True, timeout=_SECONDS, check=False,
        )  # fmt: skip
    except subprocess.TimeoutExpired:
        raise UrdfError(
            f"the file is xacro ({at}) whose expansion takes more than {_SECONDS:g} s."
        ) from None
    if done.returncode:
        reason = (done.stderr.strip().splitlines() or ["it stopped"])[-1][:300]
        raise UrdfError(f"the file is xacro ({at}) that cannot be expanded: {reason.rstrip('.')}.")
    return done.stdout
