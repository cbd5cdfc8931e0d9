"""The results of a study as columns: what was varied and what came of it, a row for every case."""

import csv
import io
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from vvdp.base.files import write_whole


@dataclass(frozen=True)
class Column:
    """One quantity over all cases; text where it is no number in some case."""

    values: npt.NDArray[np.float64] | npt.NDArray[np.str_]  # (cases,)
    unit: str


@dataclass(frozen=True)
class Failure:
    """A case that could not be carried to its end."""

    case: int
    settings: Mapping[str, object]
    reason: str


@dataclass(frozen=True)
class StudyResults:
    """Inputs and outputs of all cases of a study, in SI, in its order. Outputs of a case without results are NaN.

    `missing` are the cases still to be run after an interruption; `ran` says how many were run this time.
    """

    directory: Path
    inputs: Mapping[str, Column]
    outputs: Mapping[str, Column]
    failures: tuple[Failure, ...]
    missing: tuple[int, ...]
    ran: int
    seconds: float

    @property
    def finished(self) -> bool:
        """Whether every case has been run."""
        return not self.missing

    def write_csv(self, path: Path | str) -> None:
        """Writes a table with a row for every case; the header has the units, the last column why a case failed."""
        columns = {**self.inputs, **self.outputs}
        reasons = {failure.case: failure.reason for failure in self.failures}
        reasons |= dict.fromkeys(self.missing, "not run yet")
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(["case", *(f"{name} [{column.unit}]" for name, column in columns.items()), "failure"])
        count = len(next(iter(columns.values())).values) if columns else 0
        for case in range(count):
            values = [_written(column.values[case]) for column in columns.values()]
            writer.writerow([case, *values, reasons.get(case, "")])
        write_whole(Path(path), text.getvalue())


def _written(value: np.float64 | np.str_) -> str:
    if isinstance(value, np.str_):
        return str(value)
    return "" if np.isnan(value) else repr(float(value))
