"""Tries what a component does at random instants: does it give all the oil and power that it takes?"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np

from vvdp.base.errors import NetworkError
from vvdp.base.kinds import EXCHANGED_ENERGY, Kind
from vvdp.base.params import Params, field_kinds, field_types
from vvdp.base.units import parse
from vvdp.fluid.mixture import FluidState, fluid_state
from vvdp.fluid.oil import Oil, density, dynamic_viscosity
from vvdp.hydraulics.ports import Medium
from vvdp.network.component import Argument, Component, Role
from vvdp.simulation.values import flat, names

COUNT = 12
PRESSURES = (1.5e5, 2e7)
"""Where a component is tried [Pa, absolute]."""
TEMPERATURE = 313.15
STEP = 1e-6
"""Time [s] over which a store is differenced."""
SETTLINGS = 4
"""How often the modes of a component may change at an instant."""
EXACT, DIFFERENCED = 1e-9, 1e-5
"""What may be missing, as a share of the sum of all terms."""


@dataclass(frozen=True)
class Instant:
    """Surroundings of a component: ports, inputs and time by name, and what is its own."""

    values: Mapping[str, Any]
    state: Any
    held: Any


def check_law(component: Component, values: tuple[Params, ...], oil: Oil) -> None:
    """Refuse, with a NetworkError, a component that makes oil or power, or whose loss is negative.

    What cannot be calculated here is left to the check of the whole circuit, which says where it fails.
    """
    try:
        _try_values(component, values, oil)
    except NetworkError:
        raise
    except (ArithmeticError, TypeError, ValueError, AttributeError):
        return


@lru_cache(maxsize=256)
def _try_values(component: Component, values: tuple[Params, ...], oil: Oil) -> None:
    rng = np.random.default_rng(20261122)
    own = Trial(component, values, oil)
    with np.errstate(all="ignore"):
        for _ in range(COUNT):
            _check(own, own.instant(rng))


class Trial:
    """A component with its values, called at single instants."""

    def __init__(self, component: Component, values: tuple[Params, ...], oil: Oil) -> None:
        self.component, self.values, self.oil = component, values, oil
        self.medium = Medium(density(TEMPERATURE, oil), dynamic_viscosity(TEMPERATURE, oil))

    def instant(self, rng: np.random.Generator) -> Instant:
        """A random instant."""
        component = self.component
        values = {a.name: self._random(a, rng) for a in component.arguments}
        state = random_record(component.state, rng) if component.state else None
        instant = Instant(values, state, None)
        if component.held:
            instant = replace(instant, held=self.call(component.held, instant))
        return self._settle(instant)

    def _settle(self, at: Instant) -> Instant:
        """The same with the modes that hold there, as a run would find them."""
        told = [a.name for a in self.component.arguments if a.role is Role.MODE]
        for _ in range(SETTLINGS if told else 0):
            result = self.call(self.component.law, at)
            found = {name: float(np.floor(getattr(result, name))) for name in told}
            if all(at.values[name] == mode for name, mode in found.items()):
                break
            at = replace(at, values={**at.values, **found})
        return at

    def _random(self, argument: Argument, rng: np.random.Generator) -> Any:
        match argument.role:
            case Role.PORT:
                return fluid_state(float(rng.uniform(*PRESSURES)), self.oil)
            case Role.SHAFT | Role.SHAFT_SPEED | Role.ROD:
                return random_record(argument.type, rng)
            case Role.TIME:
                return float(rng.uniform(0.0, 1.0))
            case Role.MODE:
                return 0.0
            case Role.INPUT | Role.SURPLUS:
                assert argument.kind is not None
                return random_value(argument.kind, rng)
        return None

    def call(self, function: Callable[..., Any] | None, at: Instant) -> Any:
        """The value of one of the component's functions at an instant."""
        assert function is not None
        return function(*(self._argument_value(a, at) for a in self.component.arguments_of(function)))

    def _argument_value(self, argument: Argument, at: Instant) -> Any:
        match argument.role:
            case Role.PARAMS:
                return self._value(argument)
            case Role.STATE:
                return at.state
            case Role.HELD:
                return at.held
            case Role.MEDIUM:
                return self.medium
            case Role.OIL:
                return self.oil
        return at.values[argument.name]

    def _value(self, argument: Argument) -> Params:
        law = [a.name for a in self.component.arguments if a.role is Role.PARAMS]
        if argument.name in law:
            return self.values[law.index(argument.name)]
        found: Params = next(value for value in self.values if isinstance(value, argument.type))
        return found


def _check(trial: Trial, at: Instant) -> None:
    """Refuse what makes oil or power at an instant."""
    component = trial.component
    result = trial.call(component.law, at)
    if not np.isfinite(flat(result)).all():
        return
    losses = _losses(component, result)
    flows, powers = _port_exchange(trial, at, result)
    energy, volume = _stored_rates(trial, at, result)
    accuracy = EXACT if component.stored is None else DIFFERENCED
    powers += [energy, *losses.values(), -getattr(result, "supplied", 0.0)]
    flows.append(volume)
    size = sum(map(abs, powers))
    for name, loss in losses.items():
        kind = component.losses[name]
        exchanged = kind is not None and (kind is EXCHANGED_ENERGY or kind.low < 0.0)
        if not exchanged and loss < -EXACT * size:
            what = f"its loss {name!r}" if name else "its loss"
            raise NetworkError(
                f"{component.name}: {what} is {loss:.3g} W{_where(at)}; a sink cannot give power: is a pressure "
                "drop taken the wrong way round?"
            )
    if abs(sum(flows)) > accuracy * sum(map(abs, flows)):
        raise NetworkError(
            f"{component.name}: what it gives to its ports adds up to {sum(flows):.3g} m^3/s of oil{_where(at)}; "
            "expected 0: is a sign wrong, or a port forgotten?"
        )
    if abs(sum(powers)) > accuracy * size:
        raise NetworkError(
            f"{component.name}: it gives {sum(powers):.3g} W more than it takes{_where(at)}, its losses and stores "
            "counted: is a sign wrong, or a loss forgotten?"
        )


def _losses(component: Component, result: Any) -> dict[str, float]:
    if "losses" in names(component.result):
        return dict(result.losses._asdict())
    return {"": result.loss} if "loss" in names(component.result) else {}


def _port_exchange(trial: Trial, at: Instant, result: Any) -> tuple[list[float], list[float]]:
    """Oil [m^3/s] and power [W] that the component gives to each of its ports."""
    component = trial.component
    given = {port: getattr(result, port, 0.0) for port in component.ports}
    if component.is_passage:
        first, second = component.ends
        given |= {first: -result.flow, second: result.flow}
    flows, powers = [], []
    for port, amount in given.items():
        node = at.values[port]
        if isinstance(node, FluidState):
            flows.append(amount)
            powers.append(amount * node.enthalpy)
        else:
            powers.append(amount * (node.speed if hasattr(node, "speed") else node.velocity))
    if component.walls:
        for port, wall in trial.call(component.walls, at)._asdict().items():
            powers.append(-(at.values[port].pressure - trial.oil.reference_pressure) * wall.rate)
    return flows, powers


def _stored_rates(trial: Trial, at: Instant, result: Any) -> tuple[float, float]:
    """How fast the component's own energy [W] and oil [m^3/s] grow."""
    if trial.component.stored is None:
        return 0.0, 0.0
    after, before = (
        trial.call(trial.component.stored, _later(trial.component, at, result, dt)) for dt in (STEP, -STEP)
    )
    return (after.energy - before.energy) / (2.0 * STEP), (after.volume - before.volume) / (2.0 * STEP)


def _later(component: Component, at: Instant, result: Any, dt: float) -> Instant:
    """A little later: state, angles and positions have gone on, pressures and speeds have not."""
    values = dict(at.values)
    for name, role in component.ports.items():
        node = values[name]
        if role is Role.SHAFT:
            values[name] = node._replace(angle=node.angle + dt * node.speed)
        elif role is Role.ROD:
            values[name] = node._replace(position=node.position + dt * node.velocity)
    state = at.state if at.state is None else step_record(at.state, result.rates, dt)
    return Instant(values, state, at.held)


def random_value(kind: Kind, rng: np.random.Generator) -> float:
    """Up to twice the example of a kind, and either side of zero where the kind allows it."""
    size = abs(parse(kind.example, kind)) or 1.0
    low = -size if kind.low < 0.0 else 0.1 * size
    return float(rng.uniform(max(low, kind.low), min(2.0 * size, kind.high)))


def random_record(cls: Any, rng: np.random.Generator) -> Any:
    """A random value of a NamedTuple of kinds, at any depth."""
    kinds, types = field_kinds(cls), field_types(cls)
    return cls(*(random_value(k, rng) if (k := kinds[n]) else random_record(types[n], rng) for n in names(cls)))


def step_record(value: Any, rate: Any, dt: float) -> Any:
    """A record that has changed at a rate."""
    pairs = zip(value, rate, strict=True)
    return type(value)(*(step_record(v, r, dt) if hasattr(v, "_fields") else v + dt * r for v, r in pairs))


def _where(at: Instant) -> str:
    """The pressures at which something is wrong."""
    found: Iterator[str] = (
        f"{value.pressure / 1e5:.1f} bar at {name}"
        for name, value in at.values.items()
        if isinstance(value, FluidState)
    )
    text = ", ".join(found)
    return f" with {text}" if text else ""
