"""Claims of chapter 1 about the valve, as `vvdp rig claims` calculates them for the prototype."""

from functools import cache

from vvdp.reproduction.item import Item, ItemKind, Reproduction
from vvdp.results.verdict import Statement, number_statement
from vvdp.rivals.actuation_claim import actuation_claim
from vvdp.rivals.claim import Claim
from vvdp.rivals.driving_claim import driving_claim
from vvdp.rivals.ripple_claim import ripple_claim
from vvdp.rivals.supply_claim import supply_claim
from vvdp.rivals.throttling_claim import throttling_claim
from vvdp.steady.test_stand import stand
from vvdp.systems.system import load_system


@cache
def claims() -> tuple[Claim, ...]:
    """All claims, each calculated once."""
    held = stand(load_system("prototype"))
    works = (throttling_claim, supply_claim, driving_claim, ripple_claim, actuation_claim)
    return tuple(work(held) for work in works)


def claims_of(section: str) -> tuple[Claim, ...]:
    """The claims that a section makes."""
    return tuple(claim for claim in claims() if any(name == section for name, _ in claim.statements))


def statements_of(section: str) -> tuple[Statement, ...]:
    """Statements of a section."""
    return tuple(each for claim in claims_of(section) for name, each in claim.statements if name == section)


def _of(section: str) -> Reproduction:
    own = claims_of(section)
    return Reproduction(
        statements=statements_of(section),
        tables={name: table for claim in own for name, table in claim.tables.items()},
        charts=tuple(chart for claim in own for chart in claim.charts),
    )


def section_1_1() -> Reproduction:
    """Throttling, displacement control, and the power that moves a rotary and a linear spool."""
    return _of("section-1.1")


def section_1_4() -> Reproduction:
    """A spool that a motor turns; and where the abstract puts the rotary sensing."""
    found = _of("section-1.4")
    chapter = number_statement(
        "chapter of the rotary sensing",
        5.0,
        3.0,
        source="chapter 5 (abstract)",
        inconsistency="it is chapter 3, as section 1.4 has it; chapter 5 has the external drive",
        contradiction=("abstract: the sensing is in chapter 5", "1.4: it is in chapter 3"),
    )
    return Reproduction(statements=(chapter, *found.statements), tables=found.tables, charts=found.charts)


ITEMS = (
    Item(ItemKind.SECTION, "1.1", "What the circuit is to do better", section_1_1),
    Item(ItemKind.SECTION, "1.4", "Structure of the dissertation, and the driven spool", section_1_4),
)
