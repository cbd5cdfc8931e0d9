"""The exchange of a sampled step with a partner outside of compiled code, such as the model in a foreign FMU.

A step calls `exchange`; the package that has such partners puts the function that carries an exchange out into
`OUTSIDE`.
"""

from collections.abc import Callable, Iterable, Mapping
from typing import Any, NamedTuple

from vvdp.base.errors import RunError
from vvdp.generator.kinds import FLOAT, Intrinsic, Row

SYMBOL = "vvdp_outside"
OUTSIDE: dict[str, Callable[[], int]] = {}
"""Under `SYMBOL`, what gives the address of the function that compiled code calls; empty without partners."""


def exchange(key: float, handle: float, t: float, inputs: Any, outputs: Any) -> float:
    """Hands `inputs` to the partner at the time `t` [s] and puts what it gives into `outputs`; its handle.

    key     which partner
    handle  the one of the last exchange; 0 before the first one, which starts a new partner

    In plain Python, where functions are only tried, nothing is exchanged. A partner that fails gives NaN.
    """
    return handle


EXCHANGE = Intrinsic(
    name="vvdp_exchange",
    arguments=(FLOAT, FLOAT, FLOAT, Row(FLOAT, (None,)), Row(FLOAT, (None,))),
    text=f"""\
declare double @{SYMBOL}(double, double, double, ptr, i64, ptr, i64)
define internal double @vvdp_exchange(double %key, double %handle, double %t, ptr %in, i64 %n, ptr %out, i64 %m) {{
  %found = call double @{SYMBOL}(double %key, double %handle, double %t, ptr %in, i64 %n, ptr %out, i64 %m)
  ret double %found
}}""",
    plain=exchange,
    result=FLOAT,
    is_pure=False,
)


def outside_symbols() -> dict[str, int]:
    """The addresses that compiled code may call, by symbol."""
    return {symbol: address() for symbol, address in OUTSIDE.items()}


class Partner(NamedTuple):
    """Questions to a program with a partner outside; each function is called with the program's memory.

    is_begun  whether it has a partner already
    trouble   why its partner has failed; empty if it has not
    release   ends its partner
    """

    is_begun: Callable[[Any], bool]
    trouble: Callable[[Any], str]
    release: Callable[[Any], None]


def refuse_begun(partners: Mapping[str, Partner], memory: Mapping[str, object]) -> None:
    """Raises RunError if a run would go on from a memory whose partner is not known any more."""
    for name, partner in partners.items():
        if partner.is_begun(memory[name]):
            raise RunError(f"a run with the program {name!r} cannot be continued: the state of its model is outside")


def refuse_partners(names: Iterable[str], what: str) -> None:
    """Raises RunError if `what` is to hold programs whose models are outside, with their `names`."""
    if found := ", ".join(map(repr, names)):
        raise RunError(
            f"{what} cannot contain the program {found}: its model is a foreign FMU; export the rest without it"
        )


def troubles(partners: Mapping[str, Partner], memory: Mapping[str, object]) -> str:
    """Why a partner has failed; empty if none has."""
    found = [partner.trouble(memory[name]) for name, partner in partners.items()]
    return next(filter(None, found), "")


def release_all(partners: Mapping[str, Partner], memory: Mapping[str, object]) -> None:
    """Ends the partners of a run."""
    for name, partner in partners.items():
        partner.release(memory[name])
