"""Memory that the process may have."""

import resource

from vvdp.base.errors import VvdpError


class MemoryLimitError(VvdpError, MemoryError):
    """The process may not have as much memory as is needed."""


def require_memory(least: float) -> None:
    """Raise MemoryLimitError if the process may have less than `least` bytes of address space (`ulimit -v`)."""
    limit = resource.getrlimit(resource.RLIMIT_AS)[0]
    if limit != resource.RLIM_INFINITY and limit < least:
        raise MemoryLimitError(
            f"vvdp: the memory limit of this shell is {1e-6 * limit:.0f} MB (ulimit -v {limit // 1024}), below the "
            f"{1e-6 * least:.0f} MB that simulating needs; raise it, for example: ulimit -v unlimited"
        )
