"""The order in which the programs of a network are called at one instant: each behind those whose commands it reads."""

from collections.abc import Mapping

from vvdp.base.errors import NetworkError
from vvdp.network.network import Network, ProgramPart
from vvdp.network.nodes import Source
from vvdp.network.paths import paths_of


def ordered_programs(network: Network) -> tuple[ProgramPart, ...]:
    """The programs, each behind those whose command of the same instant it reads, else as they were added.

    A program that reads `previous` commands comes before those that it reads. A command with a latency acts later, and
    asks for no order. Raises NetworkError, which shows the chain, where there is no such order.
    """
    done: dict[str, None] = {}
    needs = {name: _needs(name, network.programs) for name in network.programs}
    for name in network.programs:
        _place(name, needs, done, [])
    return tuple(network.programs[name] for name in done)


def _needs(name: str, programs: Mapping[str, ProgramPart]) -> list[str]:
    """The programs that are called before one of that name."""
    own = programs[name]
    now = {field: source for field, source in own.reads.items() if field not in own.previous}
    before = [each for each in _origins(now, programs) if not programs[each].latency]
    others = {} if own.latency else {each: other for each, other in programs.items() if each != name}
    return before + [each for each, other in others.items() if name in _origins(_previous(other), programs)]


def _previous(program: ProgramPart) -> dict[str, Source]:
    return {field: source for field, source in program.reads.items() if field in program.previous}


def _origins(reads: Mapping[str, Source], programs: Mapping[str, ProgramPart]) -> list[str]:
    return list(dict.fromkeys(name for name in map(_origin, reads.values()) if name in programs))


def _origin(source: Source) -> str:
    return next((path.partition(".")[0] for path in paths_of(source)), "")


def _place(name: str, needs: Mapping[str, list[str]], done: dict[str, None], above: list[str]) -> None:
    if name in done:
        return
    if name in above:
        loop = " -> ".join([name, *reversed(above[above.index(name) :])])
        raise NetworkError(
            f"{name}: these programs need each other's command of the same instant: {loop}; give one of them, and no "
            "other, `previous = true`: it reads the commands of the last call"
        )
    for needed in needs[name]:
        _place(needed, needs, done, [*above, name])
    done[name] = None
