"""The step of a program with a foreign FMU, written for its variables.

At a sample the circuit is there already: the inputs are set to the values read then (with extrapolated outputs to the
mean over the period), the FMU steps to this instant, and its outputs are the command from then on. Where a command and
a reading make a power, the energy that the exchange creates or loses is counted, by the trapezoidal rule on both sides:
E = T/2 [(y_0 u_0 + y_e u_1) - u (y_0 + y_1)], with the reading and the output at the begin (0) and the end (1) of the
period T, the input u that was set, and the output y_e that the circuit had at its end (y_0 if it is held). Held, E adds
up to T/2 times the change of -y u, whatever the length of a run; extrapolated, E is proportional to T^2.

Source  ours, after the energy residual of S. Sadjina et al., Energy conservation and power bonds in co-simulations,
        Engineering with Computers 33 (2017), for the inputs that are set here.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np

from vvdp.base.kinds import EXCHANGED_ENERGY, Number, Time
from vvdp.generator.source import known_text
from vvdp.network.classes import named_tuple
from vvdp.programs.foreign.table import MADE, THROUGHPUT, TIME, Joint
from vvdp.simulation.exchange import exchange

ExchangedEnergy = Annotated[float, EXCHANGED_ENERGY]


@dataclass(frozen=True)
class StepText:
    """The step as text, and the tuples that it works with; `power` pairs outputs with inputs."""

    inputs: tuple[Joint, ...]
    outputs: tuple[Joint, ...]
    power: tuple[tuple[Joint, Joint], ...]
    extrapolates: bool

    @property
    def reading(self) -> type:
        """Inputs of the FMU."""
        return named_tuple("ForeignReading", {joint.name: Annotated[float, joint.kind] for joint in self.inputs})

    @property
    def _further(self) -> dict[str, Any]:
        """Fields of command and memory besides the outputs: rates of extrapolated outputs, and energies of the
        exchange."""
        rates = {f"{joint.name}_rate": Number for joint in self.outputs} if self.extrapolates else {}
        energies = dict.fromkeys((MADE, THROUGHPUT), ExchangedEnergy) if self.power else {}
        return {**rates, **energies}

    @property
    def first_command(self) -> Any:
        """Command before the first exchange: the start values of the FMU."""
        own = {joint.name: Annotated[float, joint.kind] for joint in self.outputs}
        time = {TIME: Time} if self.extrapolates else {}
        cls: Any = named_tuple("ForeignCommand", {**own, **time, **self._further})
        values = [joint.first for joint in self.outputs]
        return cls(*values, *[0.0] * (len(cls._fields) - len(values)))

    @property
    def memory(self) -> type:
        """Memory of the step: the handle of its instance, and the values of the last exchange."""
        last = [f"gave_{joint.name}" for joint in self.outputs] + [f"read_{joint.name}" for joint in self.inputs]
        return named_tuple(
            "ForeignMemory", {"handle": Number, TIME: Time, **dict.fromkeys(last, Number), **self._further}
        )

    def source(self, key: float) -> str:
        """The text of its functions `step` and `start`, for the FMU with a key."""
        read = [joint.name for joint in self.inputs]
        given = ", ".join(joint.from_si(f"given_{joint.name}") for joint in self.inputs) or "0.0"
        held = ", ".join(joint.from_si(f"memory.gave_{joint.name}") for joint in self.outputs)
        share = 0.5 if self.extrapolates else 0.0
        lines = [
            f"share = {share} if memory.handle > 0.0 else 0.0",
            *(f"given_{n} = reading.{n} + share * (memory.read_{n} - reading.{n})" for n in read),
            f"inputs, outputs = np.array(({given},)), np.array(({held},))",
            f"handle = exchange({key!r}, memory.handle, t, inputs, outputs)",
            "period = t - memory.time if memory.handle > 0.0 else 0.0",
            *(f"gave_{joint.name} = {joint.to_si(f'outputs[{place}]')}" for place, joint in enumerate(self.outputs)),
            *(self._ramp_lines() if self.extrapolates else ()),
            *(self._energy_lines() if self.power else ()),
        ]
        values = {"handle": "handle", TIME: "t"} | {name: f"further_{name}" for name in self._further}
        values |= {name: f"gave_{joint.name}" for joint in self.outputs for name in (joint.name, f"gave_{joint.name}")}
        values |= {f"read_{name}": f"reading.{name}" for name in read}
        begin = {f"gave_{joint.name}": repr(joint.first) for joint in self.outputs}
        return "\n".join([
            "def step(t, memory, reading, settings):",
            *(f"    {line}" for line in lines),
            f"    remembered = {_call('Memory', self.memory, values)}",
            f"    return remembered, {_call('Command', type(self.first_command), values)}\n\n",
            "def start(settings):",
            f"    return {_call('Memory', self.memory, dict.fromkeys(self.memory._fields, '0.0') | begin)}\n",  # type: ignore[attr-defined]
        ])  # fmt: skip

    def _ramp_lines(self) -> Iterator[str]:
        """Lines that find how outputs go on: as they changed over the last period."""
        yield "per_period = 1.0 / period if period > 0.0 else 0.0"
        for name in (joint.name for joint in self.outputs):
            yield f"further_{name}_rate = (gave_{name} - memory.gave_{name}) * per_period"

    def _energy_lines(self) -> Iterator[str]:
        """Lines that add up the energy that the exchange creates or loses, and its throughput."""
        made, passed = f"further_{MADE}", f"further_{THROUGHPUT}"
        yield f"{made}, {passed} = memory.{MADE}, memory.{THROUGHPUT}"
        for y, u in self.power:
            went_on = f" + memory.{y.name}_rate * period" if self.extrapolates else ""
            yield f"here_0 = memory.gave_{y.name} * memory.read_{u.name}"
            yield f"here_1 = (memory.gave_{y.name}{went_on}) * reading.{u.name}"
            yield f"there = given_{u.name} * (memory.gave_{y.name} + gave_{y.name})"
            yield f"{made} += 0.5 * period * (here_0 + here_1 - there)"
            yield f"{passed} += 0.5 * period * (abs(here_0) + abs(here_1))"

    def functions(self, name: str, key: float) -> tuple[Callable[..., Any], Callable[..., Any]]:
        """Its step and its start."""
        text = self.source(key)
        known = {"np": np, "exchange": exchange, "Memory": self.memory, "Command": type(self.first_command)}
        known["__name__"] = __name__
        exec(compile(text, known_text(text, name), "exec"), known)
        step, start = known["step"], known["start"]
        return step, start  # type: ignore[return-value]


def _call(word: str, cls: Any, values: dict[str, str]) -> str:
    return f"{word}({', '.join(f'{field}={values[field]}' for field in cls._fields)})"
