"""All items, in the order of the dissertation, and those that a person names."""

from collections.abc import Iterable, Sequence

from vvdp.base.errors import ConfigError, Fault
from vvdp.base.tables import suggestion
from vvdp.reproduction.chapter_3 import estimates, experiment, filter_equations, optics
from vvdp.reproduction.item import Item, ItemKind


def in_order(items: Iterable[Item]) -> tuple[Item, ...]:
    """Items by chapter: its figures, tables, equations and sections, each by number."""
    kinds = list(ItemKind)
    return tuple(sorted(items, key=lambda item: (item.chapter, kinds.index(item.kind), item.places)))


CHAPTER_3 = (*optics.ITEMS, *filter_equations.ITEMS, *estimates.ITEMS, *experiment.ITEMS)
ITEMS = in_order(CHAPTER_3)
ALL = "all"


def chosen_items(names: Sequence[str], items: Sequence[Item] = ITEMS) -> tuple[Item, ...]:
    """The items that `names` ask for, in the order of the dissertation; a bare number is the figure, `all` are all.

    Raises ConfigError naming every name that is none.
    """
    if ALL in names:
        return tuple(items)
    known = {item.name: item for item in items}
    asked = [f"{ItemKind.FIGURE}-{name}" if name[:1].isdigit() else name for name in names]
    faults = [
        Fault("reproduce", 0, name, f"unknown item{suggestion(full, known) or '; `vvdp reproduce --list` shows all'}")
        for name, full in zip(names, asked, strict=True)
        if full not in known
    ]
    if faults:
        raise ConfigError(faults)
    return tuple(item for item in items if item.name in asked)
