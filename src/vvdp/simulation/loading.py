"""Compiled code read from a file without what only compiling needs.

Before it reads a compiled function, Numba imports all that it can compile: the random numbers, the dictionaries, linear
algebra and with it a part of SciPy. This takes longer than a short run. Where something is compiled after all, Numba
does the same again by itself.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any


@contextmanager
def registries_left_out() -> Iterator[None]:
    """Within the block functions that Numba has kept are read without importing all that it can compile.

    It reaches into Numba. Where that is not as expected, functions are read in Numba's own way.
    """
    from numba.core import caching

    cache: Any = getattr(caching, "FunctionCache", None)
    usual = getattr(cache, "load_overload", None)
    if usual is None or not hasattr(cache, "_load_overload"):
        yield
        return

    def load(self: Any, signature: Any, context: Any) -> Any:
        try:
            from numba.core.runtime.nrt import rtsys

            rtsys.initialize(context)  # counts references to arrays; compiled code calls it
            found = self._load_overload(signature, context)
        except Exception:  # whatever is missing in another version of Numba
            return usual(self, signature, context)
        return found

    own = vars(cache).get("load_overload")  # it may be inherited
    cache.load_overload = load
    try:
        yield
    finally:
        if own is None:
            del cache.load_overload
        else:
            cache.load_overload = own
