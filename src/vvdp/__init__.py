"""vvdp: virtually variable displacement pumps and other digital hydraulics.

import vvdp

system = vvdp.load("prototype", operation={"duty_ratio": 0.4})
run = system.run(until="50 ms")
print(run.summary["efficiency"])
run.to_xarray()             # all recorded series, with units
vvdp.slider(system, "operation.duty_ratio")  # in a notebook: curves that follow a slider
vvdp.open("results/...")    # what a command has written
"""

from typing import TYPE_CHECKING, Any

from vvdp.base.version import VERSION

__version__ = VERSION
__all__ = ["Result", "Run", "System", "VvdpError", "load", "loads", "open", "slider"]

if TYPE_CHECKING:
    from vvdp.api.run import Run
    from vvdp.api.run import open_directory as open  # noqa: A004 - as `xarray.open_dataset`, after the module's name
    from vvdp.api.slider import slider
    from vvdp.api.system import System, load, loads
    from vvdp.base.errors import VvdpError
    from vvdp.results.result import Result

_PLACES = {
    "Result": ("vvdp.results.result", "Result"),
    "Run": ("vvdp.api.run", "Run"),
    "System": ("vvdp.api.system", "System"),
    "VvdpError": ("vvdp.base.errors", "VvdpError"),
    "load": ("vvdp.api.system", "load"),
    "loads": ("vvdp.api.system", "loads"),
    "open": ("vvdp.api.run", "open_directory"),
    "slider": ("vvdp.api.slider", "slider"),
}
"""Where each public name is defined; it is loaded when first asked for, so that importing vvdp takes no time."""


def __getattr__(name: str) -> Any:
    if name not in _PLACES:
        raise AttributeError(f"module 'vvdp' has no attribute {name!r}")
    from importlib import import_module

    module, attribute = _PLACES[name]
    return getattr(import_module(module), attribute)


def __dir__() -> list[str]:
    return sorted([*__all__, "__version__"])
