"""What goes to others: metadata, licences, citation, locks."""

import re
import subprocess
import sys
import tomllib
import zipfile
from email.parser import BytesParser
from pathlib import Path

import pytest
import yaml
from trove_classifiers import classifiers

import vvdp

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
EXTRAS = {name: lines for name, lines in PROJECT["optional-dependencies"].items() if name != "dev"}
LOCKS = {name: (ROOT / name).read_text(encoding="utf-8") for name in ("requirements.lock", "requirements-core.lock")}


def _name(requirement):
    return re.match(r"[\w-]+", requirement)[0].lower()


def _blocks(lock):
    """Each pin of a lock with its hashes."""
    return set(re.split(r"\n(?=\S)", LOCKS[lock].strip()))


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    folder = tmp_path_factory.mktemp("wheel")
    command = [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(folder)]
    subprocess.run(command, cwd=ROOT, check=True, capture_output=True)
    with zipfile.ZipFile(next(folder.glob("*.whl"))) as archive:
        yield archive


def test_the_wheel_says_who_made_it_and_under_which_licence(wheel):
    name = f"vvdp-{vvdp.__version__}.dist-info"
    told = BytesParser().parsebytes(wheel.read(f"{name}/METADATA"))
    assert (told["Version"], told["Author"], told["License-Expression"]) == (
        vvdp.__version__,
        "vvdp contributors",
        "Apache-2.0",
    )
    assert set(told.get_all("Provides-Extra")) == {*EXTRAS, "dev"}
    assert set(told.get_all("Classifier")) <= set(classifiers)
    assert {f"{name}/licenses/LICENSE", f"{name}/licenses/NOTICE", f"{name}/sboms/vvdp.cdx.json"} <= set(
        wheel.namelist()
    )


def test_the_wheel_is_typed_and_holds_the_package_alone(wheel):
    names = wheel.namelist()
    assert "vvdp/py.typed" in names
    assert {name.split("/")[0] for name in names} == {"vvdp", f"vvdp-{vvdp.__version__}.dist-info"}


def test_the_citation_file_is_as_its_format_has_it():
    found = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert {"cff-version", "message", "title", "authors"} <= set(found)  # these four are compulsory
    assert found["cff-version"] == "1.2.0"
    assert found["type"] == "software"
    assert str(found["version"]) == vvdp.__version__ == PROJECT["version"]
    assert found["license"] == PROJECT["license"]
    assert [author["name"] for author in found["authors"]] == [author["name"] for author in PROJECT["authors"]]
    assert set(found["keywords"]) == set(PROJECT["keywords"])


def test_the_notice_names_every_dependency_and_marks_the_lgpl():
    lines = (ROOT / "NOTICE").read_text(encoding="utf-8").lower().splitlines()
    asked = [*PROJECT["dependencies"], *(line for lines in PROJECT["optional-dependencies"].values() for line in lines)]
    for package in {_name(line) for line in asked} - {"vvdp"}:
        assert any(package in line.split() for line in lines), package
    for package in ("asammdf", "nptdms", "casadi", "moocore,", "cadquery-ocp-novtk"):
        assert any(package in line.split() and "lgpl" in line for line in lines), package


def test_the_readme_says_what_each_extra_is_for():
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    rows = {row[1]: row[0] for row in re.finditer(r"^\| `([\w-]+)` \|.*$", readme, re.MULTILINE)}
    for extra, lines in EXTRAS.items():
        for package in map(_name, lines):
            assert package in rows[extra].lower(), (extra, package)


def test_the_core_lock_is_a_part_of_the_full_one():
    core, full = _blocks("requirements-core.lock"), _blocks("requirements.lock")
    condition = re.compile(r" ; [^\\]+")  # what the core wants on one system, an extra may want on all
    assert {condition.sub(" ", block) for block in core} < {condition.sub(" ", block) for block in full}
    pinned = {_name(block) for block in core}
    assert {_name(line) for line in PROJECT["dependencies"]} < pinned
    only_extras = {_name(line) for lines in EXTRAS.values() for line in lines}
    assert not only_extras & pinned


@pytest.mark.parametrize("lock", LOCKS)
def test_every_pin_has_its_hashes_and_no_place_to_come_from(lock):
    for block in _blocks(lock):
        assert re.match(r"[\w.-]+==[\w.]+( ; [^\\]+)? \\\n", block), block[:80]
        assert block.count("--hash=sha256:") == block.count("\n") >= 1
    assert "/" not in LOCKS[lock]
