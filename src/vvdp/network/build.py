"""From a network to what is simulated: the text made into functions, the model, and the case that its values make."""

import hashlib
import linecache
import sys
import types
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import numpy as np

from vvdp.base.conservation import NOTHING, Books, Stored
from vvdp.base.errors import NetworkError
from vvdp.base.params import Params
from vvdp.base.signal import Signal
from vvdp.network.classes import Classes
from vvdp.network.component import Component
from vvdp.network.functions import Functions
from vvdp.network.network import Network
from vvdp.network.nodes import Rod, Shaft
from vvdp.network.paths import Places
from vvdp.network.program_order import ordered_programs
from vvdp.network.text import Text
from vvdp.network.trial import check_law
from vvdp.network.written_program import WrittenProgram
from vvdp.simulation.model import Case, Model, initial_case, no_mark


@dataclass(frozen=True)
class Circuit:
    """A network as it is simulated: the functions, the values to start from, the text they come from, and where each
    part of the network stands in it.
    """

    network: Network
    model: Model
    case: Case
    text: str
    places: Places

    @cached_property
    def digest(self) -> str:
        """Hash of what circuits share that differ in numbers only: the text, what its words mean, and the calls."""
        words = sorted(
            f"{name}={getattr(value, '__module__', '')}.{getattr(value, '__qualname__', value)}"
            for name, value in self.model.circuit.__globals__.items()
            if not name.startswith("__") and name in self.text
        )
        calls = [(name, p.period, p.phase, p.latency) for name, p in self.model.programs.items()]
        return hashlib.sha256(repr((self.text, words, calls)).encode()).hexdigest()

    def place(self, value: Params | Signal) -> str:
        """Where a value of the network stands in the parameters, such as `operation.pump_speed`."""
        return self.places.path(value).removeprefix("p.")

    def case_of(self, params: Any) -> Case:
        """The case of other parameters of the same classes."""
        return initial_case(self.model, type(self.case.command), params, self.case.settings)


def build(network: Network) -> Circuit:
    """The circuit of a network. Raises NetworkError where its parts do not fit together."""
    if not network.parts:
        raise NetworkError("a network needs at least one component")
    for part in network.parts.values():
        if not _is_of_package(part.component):
            check_law(part.component, part.values, network.oil)
    places = Places(network)
    classes = Classes(places)
    text = Text(places, classes)
    written = [WrittenProgram(program, text) for program in ordered_programs(network)]
    functions = Functions(text)
    blocks = functions.all()
    blocks += [block for program in written for block in program.blocks]
    whole = "\n\n\n".join("\n".join(block) for block in blocks if block) + "\n"
    module = _module(whole, tuple({**_classes_by_name(classes), **text.names}.items()))
    model = Model(
        circuit=module.circuit,
        stored=module.stored,
        start=module.start,
        conditions=module.conditions,
        programs={program.name: program.assemble(module) for program in written},
        mark=getattr(module, "mark", no_mark),
        stop=module.stop,
    )
    settings = {program.name: program.settings for program in written}
    case = initial_case(model, classes.command, classes.values, settings)
    _check_inertias(network, case)
    return Circuit(network, model, case, whole, places)


def _is_of_package(component: Component) -> bool:
    """Whether a component comes with the package, whose tests try each of its laws at random values."""
    return str(component.law.__module__).partition(".")[0] == __name__.partition(".")[0]


def _check_inertias(network: Network, case: Case) -> None:
    """Refuse what moves without a mass."""
    for name, node in network.nodes.items():
        if isinstance(node, Shaft | Rod) and not getattr(case.command.held, f"{name}_inertia") > 0.0:
            what = "inertia" if isinstance(node, Shaft) else "mass"
            raise NetworkError(f"{name} has no {what}; give it one, or join a component that has")


def _classes_by_name(classes: Classes) -> dict[str, Any]:
    return {
        "np": np,
        "Books": Books,
        "Stored": Stored,
        "NOTHING": NOTHING,
        "EMPTY_BOOKS": classes.empty_books,
        "State": classes.state,
        "Outputs": classes.outputs,
        "Supplied": classes.supplied_class,
        "Spent": classes.spent_class,
        "Totals": classes.totals,
        "Held": classes.conditions_class,
        "Modes": classes.modes,
    }


@lru_cache(maxsize=100)
def _code(text: str, file: str) -> types.CodeType:
    """The text compiled to byte code: networks that differ in numbers have the same."""
    return compile(text, file, "exec")


@lru_cache(maxsize=100)
def _module(text: str, names: tuple[tuple[str, Any], ...]) -> types.ModuleType:
    """The text as a module of its own, whose lines tracebacks and messages can show.

    The same one for the same text and classes: circuits that differ in values only are checked and linked once.
    """
    name = f"vvdp_network_{hashlib.sha256(text.encode()).hexdigest()[:12]}"
    module = types.ModuleType(name)
    module.__dict__.update(dict(names))
    file = f"<{name}>"
    linecache.cache[file] = (len(text), None, text.splitlines(keepends=True), file)
    exec(_code(text, file), module.__dict__)
    sys.modules[name] = module
    return module
