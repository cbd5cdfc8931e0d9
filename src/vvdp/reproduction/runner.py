"""Works items out one after the other, writes what each gives, and goes on where one fails."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

from vvdp.base.files import list_all, write_whole
from vvdp.report.chosen import write_figure
from vvdp.reproduction.expectation import VERDICTS, stated_table
from vvdp.reproduction.item import Item, Reproduction
from vvdp.reproduction.kept import write_statements
from vvdp.results.result import Result
from vvdp.results.store import write_result
from vvdp.results.verdict import Statement, missing_statement
from vvdp.simulation.link import quiet

VERB = "reproduce"


@dataclass(frozen=True)
class Outcome:
    """An item that was calculated; `failure` says what went wrong, where something did."""

    item: Item
    reproduction: Reproduction
    failure: str = ""

    @property
    def statements(self) -> tuple[tuple[str, Statement], ...]:
        """Its statements, each under the item's name."""
        return tuple((self.item.name, each) for each in self.reproduction.statements)


def reproduce(
    items: Sequence[Item],
    folder: Path,
    say: Callable[[str], None] = quiet,
    done: Mapping[str, Reproduction] = MappingProxyType({}),
) -> Iterator[Outcome]:
    """Works the items out, writes each into a folder of its own name below `folder`, and yields what came of it.

    `say` receives which item is begun. An item that fails is an outcome as well, and the next one follows. Items
    that are `done` already, by name, are not calculated again, and their folders are left to the caller.
    """
    for place, item in enumerate(items, 1):
        if item.name in done:
            yield Outcome(item, done[item.name])
            continue
        say(f"{place} of {len(items)}: {item.name}, {item.title}")
        outcome = _outcome(item)
        write_item(folder / item.name, outcome)
        yield outcome


def _outcome(item: Item) -> Outcome:
    try:
        return Outcome(item, item.work())
    except Exception as problem:  # whatever it is, the other items follow
        failure = f"{type(problem).__name__}: {problem}"
        return Outcome(item, Reproduction(statements=(missing_statement("item", "", failure),)), failure)


def write_item(folder: Path, outcome: Outcome) -> None:
    """Writes the data of an item as any result, and its figures as SVG and PNG."""
    folder.mkdir(parents=True)
    item, found = outcome.item, outcome.reproduction
    result = Result(
        verb=VERB,
        title=item.title,
        system=item.name,
        references=("wang2017",),
        tables={VERDICTS: stated_table(outcome.statements), **found.tables},
        charts={chart.name: chart for chart in found.charts},
    )
    write_result(folder, result, "", ("vvdp", VERB, item.name))
    if not outcome.failure:
        write_statements(folder, found.statements)
    for chart in found.charts:
        for form in ("svg", "png"):
            write_figure(folder / f"{chart.name}.{form}", chart, result)
    for picture in found.pictures:
        write_whole(folder / f"{picture.name}.svg", picture.svg)
        if picture.png:
            write_whole(folder / f"{picture.name}.png", picture.png)
    list_all(folder)


def all_statements(outcomes: Iterable[Outcome]) -> list[tuple[str, Statement]]:
    """The statements of all items, each under the name of its item."""
    return [statement for outcome in outcomes for statement in outcome.statements]
