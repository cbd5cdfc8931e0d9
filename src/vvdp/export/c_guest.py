"""Functions of a system in C that a host calls: for the time of the next event; for its own integrator rates,
indicators and events."""

from vvdp.export.c_machine import CMachine, answer_text, bench_lines, call_arguments, room_lines, wrap_lines
from vvdp.export.machine import parameters_of
from vvdp.generator.c_text import wrap
from vvdp.simulation import guest, loop, places

EVENTS_HEADER = """\

/* The time of the next event that is known after t [s]; infinite where none is. */
int {name}_upcoming({name}_machine *machine, double t, double *next);
"""
HEADER = """\

/* For the integrator of another program. `next` is the time of the next event that is known. */
enum {{ {upper}_INDICATORS = {indicators}, {upper}_POSITIONS = {rates} }};

/* Fills {upper}_POSITIONS numbers with the rates [per second] at t; those of the state come first. */
int {name}_derive({name}_machine *machine, double t, double next, double *rates);

/* Fills {upper}_INDICATORS numbers, one of which is negative where an event has happened. */
int {name}_indicate({name}_machine *machine, double t, double next, double *indicators);

/* Does all that happens at an event at t. `next` is infinite where no event is known, NaN where it cannot go on. */
int {name}_enter({name}_machine *machine, double t, double *next);

/* The place of a number of the state that has fallen below what it can be, else -1. */
int {name}_fallen(const {name}_machine *machine);

/* Moves the clock of a machine to t. */
void {name}_move({name}_machine *machine, double t);
"""


def indicator_count(machine: CMachine) -> int:
    """How many numbers show of events: two for each trigger, mode and kink."""
    return 2 * (int(machine.tables.width.size) - 1)


def guest_header(machine: CMachine) -> str:
    """The functions for callers."""
    name = machine.name
    counts = {"indicators": indicator_count(machine), "rates": machine.bench.rate.size}
    words = EVENTS_HEADER + (HEADER if machine.is_guest else "")
    return wrap_lines(words.format(name=name, upper=name.upper(), **counts))


def guest_text(machine: CMachine) -> str:
    """Their text, which follows that of the other functions."""
    name = machine.name
    count = f"{name.upper()}_INDICATORS"
    events = _function(machine, "upcoming", "double t, double *next", {})
    if not machine.is_guest:
        return events
    return "\n".join(
        [
            events,
            _bench_text(machine),
            _function(machine, "derive", "double t, double next, double *rates", {"rate": f"{name.upper()}_POSITIONS"}),
            _function(machine, "indicate", "double t, double next, double *indicators", {"found": count}),
            _function(machine, "enter", "double t, double *next", {}),
            f"int {name}_fallen(const {name}_machine *machine)\n{{",
            f"    for (int i = 0; i < {machine.begun.state.size}; i++) {{",
            "        if (machine->state[i] < floor_[i]) {\n            return i;\n        }\n    }",
            "    return -1;\n}\n",
            f"void {name}_move({name}_machine *machine, double t)\n{{",
            f"    machine->clock[{places.TIME}] = t;\n}}\n",
        ]
    )


def _bench_text(machine: CMachine) -> str:
    kind = machine.core.types[loop.BENCH]
    head = f"static {kind} bench_of({machine.name}_machine *machine)"
    return "\n".join([head, "{", *bench_lines(machine), "    return bench;", "}", ""])


def _function(machine: CMachine, entry: str, rest: str, lengths: dict[str, str]) -> str:
    """A function that hands an entry of the core what the machine keeps."""
    function, types = guest.ENTRIES[entry]
    name, kinds = machine.name, parameters_of(function, types)
    words = {"t_next": "next", "rate": "rates", "found": "indicators"}
    words |= {each: f"machine->{each}" for each in ("command", "memory", "agenda", "waiting")}
    words |= {"y": "machine->state", "params": "machine->parameters", "plan": "plan_"}
    shapes = {key: [length] for key, length in lengths.items()}
    handed = [each for argument in call_arguments(machine, kinds, words, shapes) for each in argument]
    lines = [f"    const {machine.core.types[loop.BENCH]} bench = bench_of(machine);"] if "bench" in kinds else []
    lines += room_lines(machine, entry, handed)
    call = f"{machine.core.functions[entry]}({', '.join(handed)})"
    lines.append(f"    *next = {call};" if entry in ("enter", "upcoming") else f"    {call};")
    lines.append(f"    return {answer_text(machine, entry, '0')};")
    head = f"int {name}_{entry}({name}_machine *machine, {rest})"
    return "\n".join([head, "{", *map(wrap, lines), "}", ""])
