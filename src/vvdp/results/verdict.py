"""Statements of a source beside what was found, and the verdict: one set of words for it, everywhere."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

import numpy as np

from vvdp.base.display import number, plain, value_and_unit, with_unit
from vvdp.base.kinds import NUMBER, Kind
from vvdp.results.result import Column, Table

ROUNDING = 1e-6
"""A tolerance, over the number, that is for rounding alone and is not shown."""


class Verdict(StrEnum):
    """How a statement stands."""

    REPRODUCED = "reproduced"
    CALIBRATED = "calibrated"
    NOT_REPRODUCED = "not reproduced"
    INCONSISTENT = "source inconsistent"
    UNDETERMINED = "not determined by the text"
    DRAWING = "drawing, nothing to reproduce"


class Evidence(StrEnum):
    """Evidence of a statement, and so what it proves if it holds."""

    INPUT = "input"
    IDENTITY = "identity"
    ARITHMETIC = "arithmetic of printed numbers"
    BOUND = "bound"
    CALIBRATED = "calibrated"
    SIMULATED = "simulated"
    COMPUTED = "computed"
    MEASURED = "measured"


@dataclass(frozen=True, kw_only=True)
class Statement:
    """A statement of a source, and what was found. `number_statement` and its kin make one.

    It holds if `found` [SI] lies between `low` and `high`, or outside by `tolerance` at most; `because` says where
    the tolerance comes from. `source` and `result` are words that stand for the numbers. `other` is what a second run
    finds under another `assumption` that the text allows. `contradiction` holds two printed statements that exclude
    each other, each as "place: words". If something was chosen by the printed number, `calibration` names it. All
    other texts are notes: they change no verdict.
    """

    what: str
    kind: Kind = NUMBER
    low: float = -math.inf
    high: float = math.inf
    found: float = math.nan
    other: float | None = None
    tolerance: float = 0.0
    because: str = ""
    source: str = ""
    result: str = ""
    assumption: str = ""
    inconsistency: str = ""
    contradiction: tuple[str, str] | None = None
    calibration: str = ""
    note: str = ""
    is_drawing: bool = False

    @property
    def holds(self) -> bool:
        """Whether what was found is what the source says."""
        return self._allows(self.found)

    def _allows(self, value: float) -> bool:
        return bool(self.low - self.tolerance <= value <= self.high + self.tolerance)

    @property
    def verdict(self) -> Verdict:
        """The verdict that follows from the numbers, from a second run and from what is printed twice."""
        if self.is_drawing:
            return Verdict.DRAWING
        if self.other is not None and self._allows(self.other) is not self.holds:
            return Verdict.UNDETERMINED
        if self.holds:
            return Verdict.CALIBRATED if self.calibration else Verdict.REPRODUCED
        return Verdict.INCONSISTENT if self.contradiction else Verdict.NOT_REPRODUCED

    @property
    def source_text(self) -> str:
        """The statement of the source, as people read it."""
        if self.source or (math.isinf(self.low) and math.isinf(self.high)):
            return self.source
        if self.low == self.high:
            return with_unit(self.low, self.kind)
        if math.isinf(self.low):
            return f"at most {with_unit(self.high, self.kind)}"
        if math.isinf(self.high):
            return f"at least {with_unit(self.low, self.kind)}"
        return f"{value_and_unit(self.low, self.kind, digits=4)[0]} to {with_unit(self.high, self.kind)}"

    @property
    def found_text(self) -> str:
        """The finding, as people read it."""
        return self.result or with_unit(self.found, self.kind)

    @property
    def tolerance_text(self) -> str:
        """By how much it may be off: as a share of a printed number, else with its unit."""
        share = self.tolerance / abs(self.low) if self.low == self.high != 0.0 else math.inf
        if not self.tolerance or share < ROUNDING:
            return ""
        if share < 1.0:
            return f"{plain(100.0 * share, 3)} %"
        return number(self.tolerance, 2) if self.kind is NUMBER else _width(self.tolerance, self.kind)

    @property
    def remark(self) -> str:
        """Notes on the verdict."""
        assumed = f"assumed: {self.assumption}" if self.assumption else ""
        second = "" if self.other is None else f"a second run finds {with_unit(self.other, self.kind)}"
        calibrated = f"chosen by it: {self.calibration}" if self.calibration else ""
        against = () if self.holds else (self.inconsistency, " against ".join(self.contradiction or ()))
        return "; ".join(filter(None, (assumed, second, calibrated, *against, self.note)))


SUPERSCRIPTS = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")


def _width(value: float, kind: Kind) -> str:
    """A difference of two values [SI] with the unit of their kind."""
    (zero, unit), (text, _) = (value_and_unit(each, kind) for each in (0.0, value))
    return f"{plain(_number_of(text) - _number_of(zero), 3)} {unit}".rstrip()


def _number_of(text: str) -> float:
    """A number that was written for a user."""
    mantissa, _, exponent = text.replace("−", "-").partition("·10")
    return float(mantissa) * 10.0 ** int(exponent.translate(SUPERSCRIPTS) or 0)


def number_statement(
    what: str, printed: float, found: float, kind: Kind = NUMBER, *, share: float = 0.0, **more: Any
) -> Statement:
    """A printed number [SI]: what was found may differ by a `share` of it, or by a `tolerance` [SI].

    `more` are fields of the statement.
    """
    chosen = {"tolerance": share * abs(printed)} | more
    return Statement(what=what, kind=kind, low=printed, high=printed, found=float(found), **chosen)


def exact_statement(what: str, printed: float, found: float, kind: Kind = NUMBER, **more: Any) -> Statement:
    """A printed number [SI] that what was found has to meet but for rounding. `more` are fields of the statement."""
    return number_statement(what, printed, found, kind, share=1e-9, because="rounding", **more)


def digit_statement(what: str, printed: float, found: float, kind: Kind = NUMBER, **more: Any) -> Statement:
    """A printed number [SI] with a `tolerance` of half its last digit. `more` are fields of the statement."""
    return number_statement(what, printed, found, kind, because="half of the last printed digit", **more)


def bound_statement(
    what: str, found: float, kind: Kind = NUMBER, *, low: float = -math.inf, high: float = math.inf, **more: Any
) -> Statement:
    """A bound or a band [SI], or `source=` words that a number within a band bears out. `more` are further fields."""
    return Statement(what=what, kind=kind, low=low, high=high, found=float(found), **more)


def drawing_statement(what: str, result: str) -> Statement:
    """A drawing: it states no number; `result` says what is drawn here in its place."""
    return Statement(what=what, source="drawing", result=result, is_drawing=True)


def missing_statement(what: str, source: str, missing: str) -> Statement:
    """Statement that could not be calculated, since something is `missing`; `source` are the words of the source."""
    return Statement(what=what, source=source, result=f"missing: {missing}")


def open_statement(what: str, source: str, result: str, assumption: str) -> Statement:
    """Statement that the text leaves open: `result` is as far as it can be judged, `assumption` would decide it."""
    return Statement(what=what, source=source, result=result, assumption=assumption)


def verdict_table(statements: Sequence[tuple[str, Statement]], heading: str = "item") -> Table:
    """Statements under the name of what makes them, a line each, as people read them."""

    def texts(values: Iterable[str], label: str) -> Column:
        return Column(np.array(list(values), str), None, label)

    each = [statement for _, statement in statements]
    return Table(
        title="Verdicts",
        columns={
            "item": texts((name for name, _ in statements), heading),
            "what": texts((s.what for s in each), "what"),
            "source": texts((s.source_text for s in each), "source"),
            "found": texts((s.found_text for s in each), "vvdp"),
            "tolerance": texts((s.tolerance_text for s in each), "tolerance"),
            "tolerance_source": texts((s.because for s in each), "where it comes from"),
            "verdict": texts((s.verdict.value for s in each), "verdict"),
            "remark": texts((s.remark for s in each), "note"),
        },
    )
