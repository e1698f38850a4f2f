"""How inner loops are compiled: without wrappers for Python, on arrays without reference counts.

Numba counts the references to an array with atomic instructions, at the entry of functions and at
every row that is taken; in the engine that took as long as the arithmetic. A borrowed array is the
same memory with no owner to count for.
"""

from __future__ import annotations

from typing import Any

from numba import njit, types
from numba.core import cgutils
from numba.extending import intrinsic

from rrrobot.momentum.cache import EngineCache


def compiled(**options: Any) -> Any:
    """Decorator: compile a function of the engine; its code is kept as `cache` says."""

    def decorate(function: Any) -> Any:
        dispatcher: Any = njit(nogil=True, error_model="numpy", **options)(function)
        dispatcher._cache = EngineCache(function)
        return dispatcher

    return decorate


_BARE: dict[str, Any] = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
inner: Any = compiled(**_BARE)
"""Compiles a function that only compiled functions call; its wrappers would take as long again."""
lanes: Any = compiled(**_BARE, fastmath={"contract", "nsz", "arcp"})
"""Likewise, with products and sums contracted: for loops over lanes, all of which it rounds
alike."""


def _borrowed(typing_context: Any, arrays: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        return _without_owner(context, builder, arrays, values[0])

    return arrays(arrays), generate


borrowed: Any = intrinsic(_borrowed)
"""An array, or a tuple of arrays, without owner.

Whoever borrows must not outlive the owner: borrow arguments that come from Python only, which the
caller holds until the compiled function returns.
"""


def _without_owner(context: Any, builder: Any, kind: Any, value: Any) -> Any:
    null: Any = cgutils.get_null_value
    if isinstance(kind, types.Array):
        array = context.make_array(kind)(context, builder, value)
        array.meminfo = null(array.meminfo.type)
        array.parent = null(array.parent.type)
        return array._getvalue()
    if isinstance(kind, types.BaseTuple):
        parts = [
            _without_owner(context, builder, part, builder.extract_value(value, i))
            for i, part in enumerate(kind.types)  # type: ignore[attr-defined, unused-ignore]
        ]
        return context.make_tuple(builder, kind, parts)
    return value


def in_cache(function: Any) -> bool:
    """Whether a compiled function is ready: in this process, or on disk for this processor.

    Args:
        function: what `compiled` made. Numba offers no question like this, so this looks
            into its cache's index; should that have moved, the answer is yes.
    """
    if function.signatures:
        return True
    try:
        # Each entry is for a signature, a processor and the code; the index is empty if the source
        # has changed.
        cache = function._cache
        index = cache._cache_file._load_index()
        here = function.targetctx.codegen().magic_tuple()
        return any(key[1] == here for key in index)
    except (AttributeError, IndexError, TypeError):
        return True
