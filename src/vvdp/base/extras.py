"""Libraries that come with an extra only, and the one way to say that such a library is not there."""

import importlib.util

from vvdp.base.errors import VvdpError


class MissingExtraError(VvdpError, ImportError):
    """A library that an extra brings is not installed."""


def require(module: str, extra: str, purpose: str) -> None:
    """Raises MissingExtraError where a module of an extra is not installed; nothing is imported.

    module   top-level module to be found
    extra    of vvdp that brings it
    purpose  what needs it, in the singular: "a STEP file"
    """
    if importlib.util.find_spec(module) is None:
        raise MissingExtraError(f"{purpose} needs {module}, which is not installed: pip install 'vvdp[{extra}]'")


def require_solids() -> None:
    """Raises MissingExtraError where a valve cannot be made as solids."""
    for module in ("manifold3d", "trimesh"):
        require(module, "geometry", "a valve as solids")
