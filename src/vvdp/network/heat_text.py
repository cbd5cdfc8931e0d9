"""Text that a network writes for heat; none without a heat balance."""

from collections.abc import Iterator

from vvdp.base.errors import NetworkError
from vvdp.base.select import maximum
from vvdp.base.signal import signal_value
from vvdp.hydraulics.heat import (
    HeatBalance,
    carried_heat,
    coolant_heat,
    loss_share,
    supplied_warmth,
    wall_heat,
    warm_temperature,
    warmth,
)
from vvdp.network.folding import negative
from vvdp.network.heat import warm_volumes
from vvdp.network.network import Network, Part
from vvdp.network.nodes import HydraulicNode, OilVolume
from vvdp.network.oil_options import oil_volume, part_flows
from vvdp.network.text import Text


class HeatText:
    """The lines of a network about heat."""

    def __init__(self, text: Text, balance: HeatBalance) -> None:
        self.text, self.network = text, text.network
        self.values = text.places.path(balance)
        self.volumes = warm_volumes(self.network)
        self.coolers = _coolers(self.network)

    def before(self) -> Iterator[str]:
        """Lines that say how warm the oil in each node is, before the laws."""
        now = f"{self.text.use(signal_value)}(t, {self.text.places.path(self.network.temperature)})"
        for name, node in self.network.nodes.items():
            if not isinstance(node, HydraulicNode):
                continue
            oil = self.text.places.path(node.oil)
            if isinstance(node, OilVolume):
                volume = oil_volume(self.text, name, node)
                yield f"warm_{name} = {self.text.use(warmth)}(s.{name}_heat, {volume}, {name})"
                call = f"{self.text.use(warm_temperature)}(warm_{name}, {oil}, {self.values})"
                yield f"temperature_{name} = {call}"
            else:
                yield f"warm_{name} = {self.text.use(supplied_warmth)}({now}, {oil}, {self.values})"

    def after(self) -> Iterator[str]:
        """Lines that say what heat each node gains, behind the laws."""
        losses = list[str]()
        for part in self.network.parts.values():
            if flows := part_flows(part):
                yield from self._mixture(part, flows)
                losses += filter(None, [_loss(part)])
        for name, behind in self.coolers.items():
            part = self.network.parts[name]
            coolant = self.text.call(part, part.component.cooling)
            yield f"cooled_{name} = {self.text.use(coolant_heat)}(temperature_{behind}, {coolant})"
        for name, node in self.network.nodes.items():
            if isinstance(node, HydraulicNode):
                yield f"heat_{name} = {' + '.join(self._gains(name)) or '0.0'}"
        for name in self.volumes:
            yield f"walls_{name} = {self.text.use(wall_heat)}(temperature_{name}, {self.values})"
        yield f"heat_losses = {' + '.join(losses) or '0.0'}"

    def _mixture(self, part: Part, flows: dict[str, str]) -> Iterator[str]:
        """Lines that say what a part takes out of all nodes, and how much oil it gives to them."""
        out = {node: self._positive(negative(f) if " " not in f else f"-({f})") for node, f in flows.items()}
        yield f"carried_{part.name} = {' + '.join(f'{flow} * warm_{node}' for node, flow in out.items())}"
        yield f"entering_{part.name} = {' + '.join(map(self._positive, flows.values()))}"

    def _gains(self, node: str) -> Iterator[str]:
        """The terms of what a node gains."""
        for part in self.network.parts.values():
            flows = part_flows(part)
            if node in flows:
                yield self._heat_into(part, node, flows[node])
                if loss := _loss(part):
                    share = f"{self.text.use(loss_share)}({flows[node]}, entering_{part.name}, {len(flows):.1f})"
                    yield f"{share} * ({loss})"
        yield from (f"(-cooled_{name})" for name, behind in self.coolers.items() if behind == node)

    def _heat_into(self, part: Part, node: str, flow: str) -> str:
        ends = f"({flow}, warm_{node}, carried_{part.name}, entering_{part.name})"
        return f"{self.text.use(carried_heat)}{ends}"

    def _positive(self, flow: str) -> str:
        return f"{self.text.use(maximum)}({flow}, 0.0)"

    def rates(self) -> Iterator[tuple[str, str]]:
        """The rates of the heat in each volume."""
        yield from ((f"{name}_heat", f"heat_{name} - walls_{name}") for name in self.volumes)

    def outputs(self) -> Iterator[tuple[str, str]]:
        """The temperatures."""
        yield from ((f"{name}_temperature", f"temperature_{name}") for name in self.volumes)

    def totals(self) -> dict[str, str]:
        """What the heat balance adds up; what goes outside is reported by tanks, sources and parts that hold oil."""
        outside = [
            f"heat_{name}"
            for name, node in self.network.nodes.items()
            if isinstance(node, HydraulicNode) and name not in self.volumes
        ]
        for part in self.network.parts.values():
            if part.component.stored and (flows := part_flows(part)):
                given = (self._heat_into(part, node, flow) for node, flow in flows.items())
                outside.append(f"-({' + '.join(given)})")
        walls = " + ".join([*(f"walls_{name}" for name in self.volumes), *(f"cooled_{n}" for n in self.coolers)])
        return {
            "heat_losses": "heat_losses",
            "heat_outside": " + ".join(outside) or "0.0",
            "heat_walls": walls or "0.0",
        }


def _loss(part: Part) -> str:
    """The power that a part dissipates."""
    losses = part.component.losses
    return " + ".join(f"{part.name}.losses.{name}" if name else f"{part.name}.loss" for name in losses)


def _coolers(network: Network) -> dict[str, str]:
    """The components that take heat away, and the volume behind each. Raises NetworkError where there is none."""
    found = {}
    for part in network.parts.values():
        if part.component.cooling is None:
            continue
        node = part.nodes[part.component.hydraulic_ports[-1]]
        if node not in warm_volumes(network):
            raise NetworkError(f"{part.name}: it cools the oil at {node}, which is prescribed; put a volume there")
        found[part.name] = node
    return found
