"""All items, in the order of the dissertation, and those that a user names."""

from collections.abc import Iterable, Sequence

from vvdp.base.errors import ConfigError, Fault
from vvdp.base.tables import suggestion
from vvdp.reproduction import chapter_1, chapter_2, chapter_3, chapter_4, chapter_5, chapter_6, chapter_7
from vvdp.reproduction.item import Item, ItemKind


def in_order(items: Iterable[Item]) -> tuple[Item, ...]:
    """Items by chapter: its figures, tables, equations and sections, each by number."""
    kinds = list(ItemKind)
    return tuple(sorted(items, key=lambda item: (item.chapter, kinds.index(item.kind), item.places)))


CHAPTERS = (chapter_1, chapter_2, chapter_3, chapter_4, chapter_5, chapter_6, chapter_7)
ITEMS = in_order(item for chapter in CHAPTERS for item in chapter.ITEMS)
ALL = "all"


def chosen_items(names: Sequence[str], items: Sequence[Item] = ITEMS) -> tuple[Item, ...]:
    """The items that `names` ask for, in the order of the dissertation.

    A bare number is the figure, `chapter-3` are all of a chapter, `all` are all. Raises ConfigError naming every name
    that is none.
    """
    known = {item.name: {item.name} for item in items} | {ALL: {item.name for item in items}}
    for item in items:
        known.setdefault(f"chapter-{item.chapter}", set()).add(item.name)
    asked = [f"{ItemKind.FIGURE}-{name}" if name[:1].isdigit() else name for name in names]
    faults = [
        Fault("reproduce", 0, name, f"unknown item{suggestion(full, known) or '; `vvdp reproduce --list` shows all'}")
        for name, full in zip(names, asked, strict=True)
        if full not in known
    ]
    if faults:
        raise ConfigError(faults)
    wanted = set().union(*(known[name] for name in asked))
    return tuple(item for item in items if item.name in wanted)
