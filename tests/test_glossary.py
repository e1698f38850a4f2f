"""An argument means the same in every public function: docs/reference/glossary.md says what."""

import importlib
import inspect
import re
from collections import defaultdict
from pathlib import Path

import pytest

import rrrobot as rr

PACKAGE = Path(rr.__file__).parent
PAGE = Path(__file__).parent.parent / "docs" / "reference" / "glossary.md"
ROOMS = ("", *sorted(p.parent.name for p in PACKAGE.glob("*/__init__.pyi")))
# Names of one room's own notation, as its pages and machines.md have them.
NOTATION = {"machines": r"\w{1,4}|beta|omega"}
MANY = 4


def callables():
    """Every public function, method, and class that is made from arguments; each once."""
    seen = set()
    for room in ROOMS:
        package = importlib.import_module(f"rrrobot.{room}".rstrip("."))
        for name in package.__all__:
            item = getattr(package, name)
            found = {name: item}
            if inspect.isclass(item):
                found = {
                    f"{name}.{key}": getattr(item, key)
                    for key, value in vars(item).items()
                    if not key.startswith("_")
                    and isinstance(value, type(callables) | classmethod | staticmethod)
                }
                if "Args:" in (inspect.getdoc(item) or ""):
                    found[name] = item
            for path, function in found.items():
                own = (getattr(function, "__module__", ""), getattr(function, "__qualname__", path))
                if callable(function) and own not in seen:
                    seen.add(own)
                    yield room, path, function


def used():
    """argument -> {public name: kinds of value that it takes there}."""
    uses = defaultdict(dict)
    for room, name, function in callables():
        try:
            signature = inspect.signature(function)
        except ValueError:
            continue
        for p in signature.parameters.values():
            own = NOTATION.get(room)
            if p.name in ("self", "cls", "args", "kwargs") or (own and re.fullmatch(own, p.name)):
                continue
            uses[p.name][f"{room}.{name}".strip(".")] = kinds(p.annotation)
    return uses


def kinds(annotation):
    """The alternatives of an annotation, without None and without what is inside brackets."""
    text = getattr(annotation, "__forward_arg__", None) or str(annotation)
    text = re.sub(r"^<class '(?:\w+\.)*(\w+)'>$", r"\1", text)
    while "[" in text:
        text = re.sub(r"\[[^\[\]]*\]", "", text)
    return {part.strip() for part in text.split("|")} - {"None"}


def glossary():
    """argument -> kinds of value, from the page's tables."""
    rows = re.findall(r"^\| `(\w+)` \| .+ \| (.+) \|$", PAGE.read_text(), re.MULTILINE)
    found = {name: set(re.findall(r"`([\w.]+)`", types)) for name, types in rows}
    # What is as good as an array may be one, or a number.
    return {
        name: types | ({"Array", "float"} if "ArrayLike" in types else set())
        for name, types in found.items()
    }


USED = used()


def test_what_many_functions_take_is_in_the_glossary():
    many = {name for name, uses in USED.items() if len(uses) >= MANY}
    assert many <= set(glossary())


@pytest.mark.parametrize("name", glossary())
def test_an_argument_is_the_same_kind_of_thing_everywhere(name):
    others = {where: found for where, found in USED[name].items() if not found <= glossary()[name]}
    assert USED[name], f"no public function has an argument {name}"
    assert not others, f"{name} is {glossary()[name]} by the glossary"
