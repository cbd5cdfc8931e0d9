"""Compiled code read from a file without what only compiling needs.

Before it reads a compiled function, Numba imports all that it can compile: the random numbers, the dictionaries, linear
algebra and with it a part of SciPy. This takes longer than a short run. Where something is compiled after all, Numba
does the same again by itself.
"""

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

_lock = threading.Lock()
_within: list[None] = []
"""An entry for each block at hand, of all threads: the first one changes Numba, the last one changes it back."""


@contextmanager
def registries_left_out() -> Iterator[None]:
    """Within the block functions that Numba has kept are read without importing all that it can compile.

    It reaches into Numba. Where that is not as expected, functions are read in Numba's own way.
    """
    from numba.core import caching

    cache: Any = getattr(caching, "FunctionCache", None)
    overridden = "load_overload" in vars(cache) and not _within if cache else True
    if overridden or not hasattr(cache, "_load_overload"):
        yield
        return
    with _lock:
        if not _within:
            # It is inherited there; what hides it is taken away again.
            cache.load_overload = _loading(cache.load_overload)
        _within.append(None)
    try:
        yield
    finally:
        with _lock:
            _within.pop()
            if not _within:
                del cache.load_overload


def _loading(usual: Any) -> Any:
    """A method that reads a kept function, by `usual` where it cannot."""

    def load(self: Any, signature: Any, context: Any) -> Any:
        try:
            from numba.core.runtime.nrt import rtsys

            rtsys.initialize(context)  # counts references to arrays; compiled code calls it
            return self._load_overload(signature, context)
        except Exception:  # whatever is missing in another version of Numba
            return usual(self, signature, context)

    return load
