"""Every example asks a question, runs by itself, headless, and writes what it says."""

import ast
import re
import subprocess
import sys
from pathlib import Path

import pytest

from tests.some import some

EXAMPLES = sorted((Path(__file__).parent.parent / "examples").glob("*.py"))


@pytest.mark.parametrize(
    "path",
    some(EXAMPLES, {"first_roll", "limit_cycle"}, lambda p: p.stem),
)
def test_example(path, tmp_path):
    text = path.read_text()
    assert len(text.splitlines()) < 60
    assert "?" in ast.get_docstring(ast.parse(text)).splitlines()[0]
    run = subprocess.run(
        [sys.executable, str(path)], cwd=tmp_path, capture_output=True, text=True, timeout=120
    )
    assert run.returncode == 0, run.stderr
    written = re.findall(r"^wrote (\S+)", run.stdout, flags=re.M)
    assert written
    for name in written:
        assert (tmp_path / name).stat().st_size > 0
