"""The bar that a terminal shows: by the clock while code is compiled, then by what is reached."""

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager

from rich.console import Console, RenderableType
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

from vvdp.simulation.assembly import Compiling

FULLEST = 0.98
"""How far a bar gets by the clock, since the time was only an estimate."""


class ClockedProgress(Progress):
    """A bar that moves by itself where its task has `seconds` to last."""

    def get_renderables(self) -> Iterable[RenderableType]:
        """Content of the progress display, once the tasks that go by the clock have moved."""
        for task in self.tasks:
            if seconds := task.fields["seconds"]:
                task.completed = min(task.elapsed or 0.0, FULLEST * seconds)
        yield from super().get_renderables()


@contextmanager
def reach_bar(
    screen: Console, end: float, words: Callable[[float], str]
) -> Iterator[tuple[Callable[[float], None], Callable[[str], None]]]:
    """A bar that receives how much of `end` is reached, and notices, such as what is compiled before."""
    columns = TextColumn("{task.description}"), BarColumn(), TimeRemainingColumn()
    with ClockedProgress(*columns, console=screen, transient=True) as bar:
        task = bar.add_task(words(0.0), total=None, seconds=0.0)
        begun = False

        def move(now: float) -> None:
            nonlocal begun
            if not begun:
                begun = True
                bar.reset(task, total=end, seconds=0.0)
            bar.update(task, completed=now, description=words(now))

        def say(message: str) -> None:
            nonlocal begun
            if isinstance(message, Compiling):
                begun = False
                bar.reset(task, total=message.seconds, seconds=message.seconds, description=message)
            else:
                bar.console.print(message, markup=False, highlight=False, soft_wrap=True)

        yield move, say
