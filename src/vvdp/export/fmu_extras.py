"""Files of an FMU for people and tools besides its description: terminals, its icon, and a reference result."""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import NamedTuple
from xml.sax.saxutils import quoteattr

from vvdp.export.fmu_model import INPUT, FmuModel, Output, Settable
from vvdp.simulation.run import simulate

REFERENCE_SAMPLES = 20
"""Sample periods of the reference result."""
TABLES = ("nodes", "components", "programs", "state", "command", "output")
"""First words of the names of variables, before the name of a part."""


class Extras(NamedTuple):
    """The diagram as SVG, the icon as PNG, and the reference result as CSV; each may be empty."""

    diagram: str = ""
    icon: bytes = b""
    reference: str = ""


NOTHING = Extras()


def extra_files(model: FmuModel, fmi: int, extras: Extras) -> dict[str, bytes]:
    """The files by name, at the places where FMI 2 and FMI 3 want them."""
    found = {"terminalsAndIcons/terminalsAndIcons.xml": terminals_text(model, has_icon=bool(extras.icon)).encode()}
    icon = {"terminalsAndIcons/icon.png" if fmi == 3 else "model.png": extras.icon}
    reference = {"documentation/reference.csv": extras.reference.encode()}
    return {name: each for name, each in {**(found if fmi == 3 else {}), **icon, **reference}.items() if each}


def reference_text(model: FmuModel) -> str:
    """States over 20 sample periods as CSV: the time and each state that is an output [SI], at every sample.

    The numbers are those of `vvdp run`, with all digits. Raises RunError where the run fails.
    """
    system = model.system
    stepping, period = system.stepping, system.stepping.sample_period
    until = stepping.begin + REFERENCE_SAMPLES * period
    run = simulate(
        system.model,
        system.case,
        replace(stepping, until=until, record_interval=period, window=0.0, average_from=None),
    )
    shown = [each for each in model.outputs if each.vector == "state"]
    lines = [",".join(["time", *(each.name for each in shown)])]
    for t, state in zip(run.times, run.states, strict=True):
        lines.append(",".join(repr(float(x)) for x in (t, *state[[each.place for each in shown]])))
    return "\n".join(lines) + "\n"


def terminals_text(model: FmuModel, *, has_icon: bool) -> str:
    """The text of `terminalsAndIcons.xml` of FMI 3: a terminal for each node, part and program with a variable."""
    lines = ['<?xml version="1.0" encoding="UTF-8"?>', '<fmiTerminalsAndIcons fmiVersion="3.0">']
    if has_icon:
        lines += ["  <GraphicalRepresentation>", '    <Icon x1="-100" y1="-100" x2="100" y2="100"/>']
        lines += ["  </GraphicalRepresentation>"]
    if found := terminals(model):
        lines += ["  <Terminals>", *_terminal_lines(found), "  </Terminals>"]
    return "\n".join([*lines, "</fmiTerminalsAndIcons>", ""])


def _terminal_lines(found: Mapping[str, Mapping[str, str]]) -> Iterator[str]:
    for name, members in found.items():
        yield f'    <Terminal name={quoteattr(name)} matchingRule="bus">'
        for member, variable in members.items():
            names = f"variableName={quoteattr(variable)} memberName={quoteattr(member)}"
            yield f'      <TerminalMemberVariable {names} variableKind="signal"/>'
        yield "    </Terminal>"


def terminals(model: FmuModel) -> dict[str, dict[str, str]]:
    """By name of a node, part or program, the names of its inputs and outputs by what they are of it.

    `valve_load_flow` is the `load_flow` of the terminal `valve`; a node's own number is its `pressure` or `angle`. What
    a part shows twice, as a command and as an output, is one member.
    """
    network = model.system.circuit.network
    names = sorted({*network.nodes, *network.parts, *network.programs}, key=len, reverse=True)
    found = dict[str, dict[str, str]]()
    inputs = [own for own in model.settables if own.role == INPUT]
    variables: list[Settable | Output] = [*inputs, *model.outputs]
    for each in variables:
        path = each.key
        head, _, rest = path.partition(".")
        path = rest if head in TABLES and rest else path
        owner = next((name for name in names if path == name or path.startswith((f"{name}.", f"{name}_"))), "")
        if owner:
            member = path[len(owner) + 1 :] or _quantity(each)
            found.setdefault(owner, {}).setdefault(member, each.name)
    return dict(sorted(found.items()))


def _quantity(variable: Settable | Output) -> str:
    kind = variable.kind
    return "value" if kind is None else kind.name.removesuffix(" level").replace(" ", "_")
