"""Public names that load when they are first used.

A package's face is its stub, `__init__.pyi`: imports, one for each public name, which type
checkers and editors read as they stand. `face` reads the same file, so that a name is written
once and nothing loads before its use (PEP 562, and SPEC 1 of Scientific Python).
"""

from __future__ import annotations

import ast
import importlib
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any


def face(
    package: str, file: str
) -> tuple[Callable[[str], Any], Callable[[], list[str]], list[str]]:
    """`__getattr__`, `__dir__` and `__all__` of a package, from the stub beside its file.

    What the stub imports from the package itself are its rooms: they are attributes, and stay out
    of `__all__`, so that `import *` brings no modules.

    Args:
        package: its `__name__`.
        file: its `__file__`.

    Example:
        >>> import rrrobot
        >>> "simulate" in rrrobot.__all__, "reduction" in rrrobot.__all__
        (True, False)
    """
    homes = _imports(Path(file).with_name("__init__.pyi"))
    rooms = [name for name, home in homes.items() if home == package]

    def load(name: str) -> Any:
        home = homes.get(name)
        if home is None:
            raise AttributeError(f"module {package!r} has no attribute {name!r}.{_hint(name)}")
        path = f"{home}.{name}" if home == package else home
        module = importlib.import_module(path)
        found = module if home == package else getattr(module, name)
        setattr(sys.modules[package], name, found)
        return found

    def names() -> list[str]:
        return sorted({*vars(sys.modules[package]), *homes})

    def _hint(name: str) -> str:
        if name.startswith("_"):
            return ""
        for room in rooms:
            stub = Path(file).parent / room / "__init__.pyi"
            if stub.exists() and name in _imports(stub):
                return f" It is {package}.{room}.{name}."
        return ""

    return load, names, sorted(set(homes) - set(rooms))


def _imports(stub: Path) -> dict[str, str]:
    """Module that each name of a stub comes from."""
    tree = ast.parse(stub.read_text(encoding="utf-8"))
    return {
        alias.name: node.module
        for node in tree.body
        if isinstance(node, ast.ImportFrom) and node.module
        for alias in node.names
    }
