"""Exercises of a course: a question about a circuit, the answer by simulation, the usual mistakes in words."""

import math
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from vvdp.api.run import Run
from vvdp.api.system import load, loads
from vvdp.base.display import with_unit
from vvdp.base.errors import VvdpError
from vvdp.base.files import write_whole
from vvdp.base.units import parse
from vvdp.results.result import Number

Mistake = tuple[Callable[[float], float], str]
"""The wrong number [SI] that a mistake gives instead of the right one, and a sentence on the mistake."""
ALWAYS: tuple[Mistake, ...] = (
    (lambda right: -right, "The number is right, its sign is not: look at which way is positive."),
    (lambda right: 60.0 * right, "That is 60 times too large: seconds and minutes are mixed up."),
    (lambda right: right / 60.0, "That is 60 times too small: seconds and minutes are mixed up."),
    (lambda right: math.tau * right, "That is 2 pi times too large: radians and revolutions are mixed up."),
    (lambda right: right / math.tau, "That is 2 pi times too small: radians and revolutions are mixed up."),
    (lambda right: 2.0 * right, "That is twice as much as it should be."),
    (lambda right: 0.5 * right, "That is half of what it should be."),
    (lambda right: 10.0 * right, "That is 10 times too large: is the unit the one that you meant?"),
    (lambda right: 0.1 * right, "That is 10 times too small: is the unit the one that you meant?"),
    (lambda right: 1e3 * right, "That is 1000 times too large: look at the powers of ten of the units."),
    (lambda right: 1e-3 * right, "That is 1000 times too small: look at the powers of ten of the units."),
)
"""Mistakes that are possible in every exercise."""
USAGE = 2


@dataclass(frozen=True)
class Verdict:
    """Whether an answer is right, and the sentence on it."""

    is_right: bool
    words: str


@dataclass(frozen=True)
class Exercise:
    """A question, the circuit whose simulation answers it, and what goes wrong.

    circuit    text of a system file, or the name of a shipped system
    key        what of the run's summary is asked for
    hint       for an answer that is wrong in another way than the `mistakes`
    tolerance  largest share by which an answer may differ
    """

    question: str
    circuit: str
    key: str
    hint: str
    mistakes: tuple[Mistake, ...] = ()
    tolerance: float = 0.02

    @cached_property
    def run(self) -> Run:
        """The simulation."""
        return (loads(self.circuit) if "\n" in self.circuit else load(self.circuit)).run()

    @property
    def right(self) -> Number:
        """The right number."""
        return self.run.numbers[self.key]

    def verdict(self, answer: str) -> Verdict:
        """Whether an answer, a number with its unit, is right, and what is wrong with it otherwise."""
        kind = self.right.kind
        try:
            found = parse(answer, kind)
        except VvdpError as problem:
            return Verdict(is_right=False, words=str(problem))
        right = self.right.value
        if self._is_near(found, right):
            return Verdict(is_right=True, words=f"Right. The simulation gives {with_unit(right, kind)}.")
        for wrong, words in (*self.mistakes, *ALWAYS):
            if self._is_near(found, wrong(right)):
                return Verdict(is_right=False, words=words)
        way = "large" if abs(found) > abs(right) else "small"
        return Verdict(is_right=False, words=f"That is too {way}. {self.hint}")

    def _is_near(self, found: float, expected: float) -> bool:
        return abs(found - expected) <= self.tolerance * abs(expected)

    def main(self, arguments: Sequence[str] | None = None) -> int:
        """Prints the question, or what is to be said of the answer; the exit code is 1 where that is wrong.

        `--page FILE.html` writes the circuit as a page that runs it, instead (needs the extra `web`).
        """
        given = sys.argv[1:] if arguments is None else list(arguments)
        if not given:
            print(f"{self.question.strip()}\n\nGive the answer with its unit, for example {self.right.kind.example!r}.")
            return 0
        if given[0] == "--page":
            return self._page(given[1:])
        verdict = self.verdict(" ".join(given))
        print(verdict.words)
        return 0 if verdict.is_right else 1

    def _page(self, files: Sequence[str]) -> int:
        from vvdp.web.page import web_page

        if len(files) != 1 or Path(files[0]).exists():
            print("--page takes one file, which is not there yet", file=sys.stderr)
            return USAGE
        write_whole(Path(files[0]), web_page(self.run.system).html)
        return 0


def ask(name: str, question: str | None, **exercise: Any) -> Exercise:
    """The exercise of a file, which checks an answer where the file is run as a program.

    name, question  `__name__` and `__doc__` of the file
    exercise        the other fields of `Exercise`
    """
    found = Exercise(question or "", **exercise)
    if name == "__main__":
        sys.exit(found.main())
    return found
