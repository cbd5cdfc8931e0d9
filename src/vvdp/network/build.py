"""From a network to what is simulated: the text made into functions, the model, and the case that its values make."""

import hashlib
import linecache
import sys
import types
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from vvdp.base.books import NOTHING, Books, Stored
from vvdp.base.errors import NetworkError
from vvdp.network.classes import Classes
from vvdp.network.network import Network, Watcher
from vvdp.network.nodes import DrivenShaft, OilVolume, PressureSource, Rod, Shaft, Tank
from vvdp.network.paths import Places
from vvdp.network.text import Text
from vvdp.simulation.model import Case, Model, Program, no_mark, started_case


@dataclass(frozen=True)
class Circuit:
    """A network as it is simulated: the functions, the values to start from, and the text they come from."""

    network: Network
    model: Model
    case: Case
    text: str


def build(network: Network) -> Circuit:
    """The circuit of a network. Raises NetworkError where its parts do not fit together."""
    if not network.parts:
        raise NetworkError("a network needs at least one component")
    places = Places(network)
    classes = Classes(places)
    text = Text(places, classes)
    measures = {name: _measure(program, text) for name, program in network.programs.items()}
    blocks = [text.circuit(), text.conditions(), text.stored(), text.start(), text.stop(), text.mark(), *measures.values()]
    whole = "\n\n\n".join("\n".join(block) for block in blocks if block) + "\n"
    given = {
        **text.names,
        "np": np,
        "Books": Books,
        "Stored": Stored,
        "NOTHING": NOTHING,
        "EMPTY_BOOKS": classes.empty_books,
        "State": classes.state,
        "Outputs": classes.outputs,
        "Supplied": classes.supplied,
        "Spent": classes.spent,
        "Totals": classes.totals,
        "Held": classes.held,
    }
    module = _module(whole, given)
    model = Model(
        circuit=module.circuit,
        stored=module.stored,
        start=module.start,
        conditions=module.conditions,
        programs={n: _program(p, getattr(module, f"measure_{n}")) for n, p in network.programs.items()},
        mark=getattr(module, "mark", no_mark),
        stop=module.stop,
    )
    start = classes.start(**{value.name: value.value for value in classes.own_starts})
    params = classes.params(**{name: value for name, (_, value) in places.fields.items()}, start=start)
    settings = {name: NOTHING if p.settings is None else p.settings for name, p in network.programs.items()}
    return Circuit(network, model, started_case(model, classes.command, params, settings), whole)


def _program(watcher: Watcher, measure: Callable[..., Any]) -> Program:
    return Program(
        measure=measure,
        step=watcher.step,
        command=watcher.command,
        start=watcher.start,
        trigger=watcher.trigger,
        period=watcher.period,
        phase=watcher.phase,
        latency=watcher.latency,
    )


def _measure(program: Watcher, text: Text) -> list[str]:
    """The function that reads what a program's sensors see."""
    fields = [f"{name}={_reading(path, program.name, text)}" for name, path in program.reads.items()]
    return [
        f"def measure_{program.name}(t, s, outputs, p):",
        f"    return {text.use(program.reading)}({', '.join(fields)})",
    ]


def _reading(path: str, where: str, text: Text) -> str:
    name, _, what = path.partition(".")
    net = text.network
    if path == "t":
        return "t"
    node = net.nodes.get(name)
    match node, what:
        case OilVolume(), "pressure":
            return f"s.{name}"
        case (Tank() | PressureSource()), "pressure":
            return f"outputs.{name}_pressure"
        case Shaft(), ("angle" | "speed") | None:
            return f"s.{path}"
        case Rod(), ("position" | "velocity"):
            return f"s.{path}"
        case DrivenShaft(), "angle":
            return f"s.{name}"
    text.read(path, where)  # refuses a path that leads nowhere
    part = net.parts.get(name)
    state = part.component.state if part else None
    if part and state is not None and what in state._fields and what not in part.component.outputs:  # type: ignore[attr-defined]
        return f"s.{path}"
    if node is not None:
        raise NetworkError(f"{where} reads {path!r}, which no sensor measures")
    return f"outputs.{name}_{what}"


def _module(text: str, names: dict[str, Any]) -> types.ModuleType:
    """The text as a module of its own, whose lines tracebacks and messages can show."""
    name = f"vvdp_network_{hashlib.sha256(text.encode()).hexdigest()[:12]}"
    module = types.ModuleType(name)
    module.__dict__.update(names)
    file = f"<{name}>"
    linecache.cache[file] = (len(text), None, text.splitlines(keepends=True), file)
    exec(compile(text, file, "exec"), module.__dict__)
    sys.modules[name] = module
    return module
