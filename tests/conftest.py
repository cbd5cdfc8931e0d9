"""What all tests share: programs and samples that may be missing."""

import os
import re
import shutil
import sys
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple, NoReturn

import pytest
from hypothesis import settings

if TYPE_CHECKING:
    from vvdp.steady.test_stand import Stand

# Times of single examples say nothing on a shared machine; in continuous integration every run draws the same ones.
settings.register_profile("local", deadline=None)
settings.register_profile("ci", deadline=None, derandomize=True)
settings.load_profile("ci" if os.environ.get("CI") else "local")


def required_program(name: str) -> str:
    """Path of a system program. Where it is missing, skips, or fails if `VVDP_REQUIRE` names it."""
    if path := shutil.which(name):
        return path
    return not_tested(f"{name} is not installed", name)


def not_tested(reason: str, word: str) -> NoReturn:
    """Skips with one line that says so, or fails if `VVDP_REQUIRE` names `word`."""
    message = f"NOT TESTED: {reason}"
    if word in os.environ.get("VVDP_REQUIRE", "").split(","):
        pytest.fail(f"{message}, and VVDP_REQUIRE demands it")
    print(message, file=sys.stderr)
    pytest.skip(message)


@pytest.fixture(scope="session", name="not_tested")
def not_tested_fixture() -> Callable[[str, str], NoReturn]:
    """`not_tested`, for the conftest of a folder."""
    return not_tested


@pytest.fixture(scope="session")
def source_stand() -> "Stand":
    """The prototype against a source that holds the load pressure."""
    from vvdp.steady.test_stand import stand
    from vvdp.systems.system import load_system

    return stand(load_system("prototype-constant-load"))


@pytest.fixture(scope="session")
def orifice_stand() -> "Stand":
    """The prototype with its load line and orifice."""
    from vvdp.steady.test_stand import stand
    from vvdp.systems.system import load_system

    return stand(load_system("prototype"))


@pytest.fixture(scope="session")
def chromium() -> str:
    """Path of the browser."""
    return required_program("chromium")


class KeySection(NamedTuple):
    """What docs/keys.md says of a verb: unit and meaning of each key, and the verbs whose keys are there as well.

    A word in angle brackets stands for one of the words that `names` has of it, or for any.
    """

    rows: Mapping[str, tuple[str, str]]
    others: tuple[str, ...]
    names: Mapping[str, tuple[str, ...]]

    def pattern(self, key: str) -> str:
        """The keys that a row describes, as a regular expression."""
        return re.sub(r"<(\w+)>", lambda word: f"(?:{'|'.join(self.names.get(word[1], (ANY,)))})", key)


ANY = r"\w+"


@pytest.fixture(scope="session")
def key_sections() -> dict[str, KeySection]:
    """docs/keys.md by verb."""
    page = (Path(__file__).parents[1] / "docs" / "keys.md").read_text("utf-8")
    found = {}
    for text in page.split("\n## `vvdp ")[1:]:
        verb, _, text = text.partition("`\n")
        rows = re.findall(r"^\| `([\w<>]+)` \| ([^|]+) \| ([^|]+) \|$", text, re.MULTILINE)
        shared = re.search(r"The keys of (.*?) are there as well", text)
        told = re.findall(r"`<(\w+)>` is ((?:`\w+`(?:,\s| or\s))+(?:`\w+`|nothing))", text)
        names = {name: tuple(re.findall(r"`(\w+)`|nothing", listed)) for name, listed in told}
        assert len({key for key, _, _ in rows}) == len(rows), verb
        others = tuple(re.findall(r"`vvdp ([a-z -]+)`", shared[1])) if shared else ()
        found[verb] = KeySection({key: (unit, meaning) for key, unit, meaning in rows}, others, names)
    return found


@pytest.fixture(scope="session")
def keys_as_described(key_sections: dict[str, KeySection]) -> Callable[..., None]:
    """Holds what a verb has printed, at one time or several, against docs/keys.md.

    Every key is described, and every key that is described is there, but for those that the page says may be absent.
    """

    def check(verb: str, *printed: Iterable[str]) -> None:
        section = key_sections[verb]
        found = {key for each in printed for key in each}
        own = [section.pattern(key) for key in section.rows]
        known = own + [key_sections[other].pattern(key) for other in section.others for key in key_sections[other].rows]
        assert sorted(key for key in found if not any(re.fullmatch(each, key) for each in known)) == []
        always = [key for key, (_, meaning) in section.rows.items() if not re.search(r"\bonly\b|\babsent\b", meaning)]
        assert [key for key in always if not any(re.fullmatch(section.pattern(key), each) for each in found)] == []

    return check
