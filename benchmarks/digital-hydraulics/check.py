"""Checks an answer to a case of the benchmark set. It needs Python 3.11 and nothing else.

python check.py CASE ANSWER      ANSWER: a CSV file with columns quantity and value, in the units of the case;
                                 for a case with records a folder with a CSV file for each of them
python check.py --list           the cases

Exit status: 0 all within their bounds, 1 some not, 2 nothing to check.
"""

import csv
import math
import sys
import tomllib
from pathlib import Path

HERE = Path(__file__).parent


def cases() -> list[str]:
    """Names of all cases."""
    return sorted(path.parent.name for path in HERE.glob("*/case.toml"))


def read_table(path: Path) -> list[dict[str, str]]:
    """The rows of a CSV file with a header."""
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def read_answer(case: str, answer: Path) -> dict[str, float]:
    """Each quantity of the case that the answer gives; of records, the errors of the speed."""
    definition = tomllib.loads((HERE / case / "case.toml").read_text("utf-8"))
    if "records" not in definition:
        return {row["quantity"]: float(row["value"]) for row in read_table(answer)}
    found = {}
    for name, record in definition["records"].items():
        if (answer / f"{name}.csv").is_file():
            truth = read_table(HERE / case / f"{name}-truth.csv")
            found[name] = speed_error(truth, read_table(answer / f"{name}.csv"), record["scored_from"])
    return found


def speed_error(truth: list[dict[str, str]], answer: list[dict[str, str]], scored_from: float) -> float:
    """Root of the mean square of the error [rad/s] from `scored_from` [s] on; infinite where rows are missing."""
    said = {row["time_s"]: float(row["speed_rad_s"]) for row in answer}
    scored = [row for row in truth if float(row["time_s"]) >= scored_from]
    errors = [said.get(row["time_s"], math.inf) - float(row["speed_rad_s"]) for row in scored]
    return math.sqrt(math.fsum(error * error for error in errors) / len(errors))


def verdict(row: dict[str, str], found: float | None) -> str:
    """Whether a quantity lies within its bounds; an empty bound is none."""
    if found is None:
        return "missing"
    lower, upper = float(row["lower"] or -math.inf), float(row["upper"] or math.inf)
    return "within" if lower <= found <= upper else "OUTSIDE"


def problem(given: list[str]) -> str:
    """What is wrong with the arguments; nothing if they can be worked with."""
    if len(given) != 2:
        return str(__doc__)
    if given[0] not in cases():
        return f"no case {given[0]!r}; the cases are {', '.join(cases())}"
    return "" if Path(given[1]).exists() else f"no such file: {given[1]}"


def main(given: list[str]) -> int:
    """Prints a row for each quantity of the case."""
    if given == ["--list"]:
        print("\n".join(cases()))
        return 0
    if wrong := problem(given):
        print(wrong, file=sys.stderr)
        return 2
    case, answer = given[0], read_answer(given[0], Path(given[1]))
    all_within = True
    for row in read_table(HERE / case / "expected.csv"):
        found = answer.get(row["quantity"])
        told = verdict(row, found)
        all_within &= told == "within"
        shown = "-" if found is None else f"{found:.6g}"
        expected = f"{row['expected'] or '-'} [{row['lower']}, {row['upper']}] {row['unit']}"
        print(f"{row['quantity']:<20} {shown:>12}   expected {expected:<50} {told}")
    return 0 if all_within else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
