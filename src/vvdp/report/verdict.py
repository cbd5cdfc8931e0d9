"""What a reader has to know before the numbers: is the run to be trusted, and what lies outside its bounds."""

from collections.abc import Iterator
from dataclasses import dataclass

from vvdp.report.reading import BAR, Reading
from vvdp.report.wording import fixed, number, plain
from vvdp.simulation.balance import LIMIT
from vvdp.systems.overview import lowest_volume
from vvdp.systems.summary import cavitation_pressure


@dataclass(frozen=True)
class Badge:
    """A word on the state of the run; `grade` is good, warn, bad or empty."""

    words: str
    grade: str = ""


@dataclass(frozen=True)
class Notice:
    """Something wrong, with its numbers, and what to do about it."""

    title: str
    found: str
    remedy: str
    grave: bool = False


def keeps_books(reading: Reading) -> bool:
    """Whether the run was checked by its balances."""
    return "trusted" in reading.results.summary


def trust(reading: Reading) -> Iterator[Badge]:
    """Whether the run is whole and its balances close."""
    if not keeps_books(reading):
        yield Badge("not checked: no balances", "warn")
    elif reading.has("trusted"):
        yield Badge("trusted", "good")
    else:
        yield Badge("NOT TRUSTED", "bad")
    if not reading.has("finished"):
        yield Badge("interrupted", "bad")


def settling(reading: Reading) -> Iterator[Badge]:
    """Whether the periods between marks have settled."""
    if not reading.number("averaged_periods") >= 1:
        yield Badge(f"no {reading.period}", "warn")
    elif reading.has("settled"):
        yield Badge("settled", "good")
    else:
        yield Badge("not settled", "warn")


def cavitating(reading: Reading) -> Iterator[Badge]:
    """Whether any volume cavitates."""
    yield Badge("cavitation", "bad") if reading.has("cavitation") else Badge("no cavitation", "good")


def manner(reading: Reading) -> Iterator[Badge]:
    """How the run was computed, and from how many assumed values."""
    if reading.has("stiff_method"):
        yield Badge("stiff method at the end")
    yield Badge(f"{len(reading.system.assumed)} assumed values")


def notices(reading: Reading) -> Iterator[Notice]:
    """What may be wrong with the run of any circuit, gravest first."""
    limit = plain(LIMIT)
    if keeps_books(reading) and not reading.has("trusted"):
        energy, mass = (number(reading.number(f"{name}_residual"), 3) for name in ("energy", "mass"))
        tolerance = float(reading.results.meta["relative_tolerance"])
        yield Notice(
            "NOT TRUSTED: the balances do not close",
            f"Energy residual {energy}, mass residual {mass} of the throughput; the limit is {limit}.",
            f"Do not use these numbers. Run again with a smaller run.relative_tolerance (it was {plain(tolerance)}; "
            "try a tenth of it). If the residual stays, the circuit's equations lose oil or energy: report it.",
            True,
        )
    if not reading.has("finished"):
        until = float(reading.results.meta["until_s"])
        yield Notice(
            "Interrupted run",
            f"The run was stopped at {plain(reading.number('duration_s'), 4)} s of {plain(until)} s. "
            "Means cover what was reached.",
            "Run again to the end, or ask for a shorter run with --until.",
            True,
        )
    lowest = lowest_volume(reading.system, reading.results.summary)
    if reading.has("cavitation") and lowest is not None:
        name, pressure = lowest[0].replace("_", " "), lowest[1]
        yield Notice(
            f"Cavitation at the {name}",
            f"The {name} pressure fell to {fixed(pressure / BAR, 3)} bar absolute, "
            f"below the limit of {plain(cavitation_pressure(reading.system) / BAR)} bar absolute.",
            "Below the limit the oil model does not hold. Raise the tank pressure, move things more slowly, or "
            "enlarge what feeds it.",
            True,
        )


def remarks(reading: Reading) -> tuple[str, ...]:
    """What the simulation itself remarked."""
    return tuple(map(str, reading.results.meta.get("remarks", ())))
