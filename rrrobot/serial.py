"""One registry of what can be saved: a class under a name, its `to_dict`, and the way back.

A class that is registered as "egg" writes {"type": "egg", ...}; `from_dict` finds the class by
that name and calls its own `from_dict`, or its constructor with the other entries as keywords. A
shell, ground, gait or damping of a user's own is saved and loaded like ours once it is registered.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, TypeVar

from rrrobot.errors import ParameterError

T = TypeVar("T")
_CLASSES: dict[str, type] = {}


def register(name: str) -> Callable[[type[T]], type[T]]:
    """Class decorator: what `to_dict` writes with "type": name is read back as this class.

    The class may be defined anew under the same name, as in a notebook; another class may not
    take the name.

    Raises:
        ParameterError: the name is taken.

    Example:
        >>> import rrrobot as rr
        >>> from rrrobot.contact.saved import surface_from_dict
        >>> @rr.register("egg")
        ... class Egg(rr.Sphere):
        ...     def to_dict(self):
        ...         return {"type": "egg", "radius": self.radius}
        >>> surface_from_dict(Egg(0.2).to_dict())
        Egg(radius=0.2)
    """

    def keep(cls: type[T]) -> type[T]:
        known = _CLASSES.get(name)
        if known is not None and known.__qualname__ != cls.__qualname__:
            raise ParameterError(
                f"the name {name!r} is taken by {known.__qualname__}: register "
                f"{cls.__qualname__} under another."
            )
        _CLASSES[name] = cls
        return cls

    return keep


def from_dict(data: Mapping[str, Any], family: type[T], what: str) -> T:
    """The object that `to_dict` wrote.

    Args:
        data: with the entry "type".
        family: base class that it must have.
        what: the family in words, for messages: "shell", "gait".

    Raises:
        ParameterError: no such type, or one of another family.
    """
    name = data.get("type") if isinstance(data, Mapping) else None
    cls = _CLASSES.get(name) if isinstance(name, str) else None
    if cls is None or not issubclass(cls, family):
        known = sorted(n for n, c in _CLASSES.items() if issubclass(c, family))
        raise ParameterError(
            f"{what} type is {str(name)[:80]!r}: known are {', '.join(known)}. A class of your own "
            "is known once rrrobot.register has it."
        )
    own = getattr(cls, "from_dict", None)
    parts = {key: value for key, value in data.items() if key != "type"}
    made = own(parts) if own is not None else cls(**parts)
    return made
