"""Which OpenFOAM is taken, and what is said where there is none; programs that fail."""

import os
import re
import signal
import stat
from types import SimpleNamespace

import pytest
from tests.words import wording

from vvdp.base.errors import RunError, WriteError
from vvdp.cfd import programs
from vvdp.cfd.engine import FOLDER, PROGRAMS, MissingProgramError, OpenFoam, find_openfoam
from vvdp.cfd.programs import run_program


@pytest.fixture
def pretended(tmp_path, monkeypatch):
    """Makes programs of OpenFOAM that all do the same; no other program is found."""

    def make(script, names=PROGRAMS):
        (tmp_path / "bin").mkdir()
        (tmp_path / "etc").mkdir()
        (tmp_path / "etc" / "controlDict").touch()
        for name in names:
            path = tmp_path / "bin" / name
            path.write_text(f"#!/bin/sh\n{script}\n")
            path.chmod(path.stat().st_mode | stat.S_IXUSR)
        monkeypatch.setenv("PATH", str(tmp_path / "bin"))
        monkeypatch.setenv(FOLDER, str(tmp_path))
        return OpenFoam(1912, tmp_path)

    return make


def test_without_openfoam_the_command_to_install_it_is_told(monkeypatch, tmp_path):
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(MissingProgramError, match=wording.cfd.not_installed.format(program="blockMesh")):
        find_openfoam()


@pytest.mark.parametrize(
    ("words", "version"),
    [
        ("Using: OpenFOAM- (1912) - visit www.openfoam.com", 1912),
        ("Using: OpenFOAM-v2312 (2312) - visit www.openfoam.com", 2312),
    ],
)
def test_the_version_is_read_from_its_help(words, version, pretended):
    pretended(f'echo "{words}"')
    assert find_openfoam().version == version


def test_an_old_version_and_that_of_others_are_refused(pretended, tmp_path):
    pretended('echo "Using: OpenFOAM-v1806 (1806) - visit www.openfoam.com"')
    with pytest.raises(MissingProgramError, match=wording.cfd.too_old.format(version=1806, least=1912)):
        find_openfoam()
    for path in (tmp_path / "bin").iterdir():
        path.write_text('#!/bin/sh\necho "Using: OpenFOAM-8 (see https://openfoam.org)"\n')
    with pytest.raises(MissingProgramError, match=wording.cfd.no_version):
        find_openfoam()


def test_a_folder_without_its_files_is_named(pretended, monkeypatch, tmp_path):
    pretended("true")
    (tmp_path / "etc" / "controlDict").unlink()
    with pytest.raises(MissingProgramError, match=wording.cfd.missing_file.format(file="etc/controlDict")):
        find_openfoam()


def test_the_installed_one_is_found(openfoam):
    assert openfoam.version >= 1912
    assert openfoam.environment[FOLDER] == str(openfoam.folder)


def test_programs_do_not_know_of_a_job_and_are_bound_to_no_core(monkeypatch, tmp_path):
    monkeypatch.setenv("SLURM_NTASKS", "1")
    monkeypatch.setenv("KEPT", "yes")
    found = OpenFoam(1912, tmp_path).environment
    assert "SLURM_NTASKS" not in found
    assert found["KEPT"] == "yes"
    assert found["OMPI_MCA_hwloc_base_binding_policy"] == "none"


FATAL = """echo '--> FOAM FATAL ERROR:
Cannot find patchField entry for background

    From function void foo()
FOAM exiting'
exit 1"""


@pytest.mark.parametrize(
    ("script", "message"),
    [
        (
            FATAL,
            wording.cfd.failed.format(program="simpleFoam") + "Cannot find patchField entry for background; see .*log",
        ),
        ("kill -9 $$", re.escape(wording.cfd.was_killed.format(program="simpleFoam") + wording.cfd.rerun)),
        ("exit 137", re.escape(wording.cfd.was_killed.format(program="simpleFoam"))),
        ("kill -8 $$", wording.cfd.flow_diverged),
        ("echo '#1  Foam::sigFpe::sigHandler(int)'; exit 136", wording.cfd.flow_diverged),
        ("exit 3", wording.cfd.failed_with_code.format(program="simpleFoam", code=3)),
    ],
)
def test_what_went_wrong_is_told(script, message, pretended, tmp_path):
    openfoam = pretended(script)
    with pytest.raises(RunError, match=message):
        run_program(("simpleFoam",), tmp_path, openfoam)
    assert (tmp_path / "log.simpleFoam").is_file()


def test_a_full_disk_is_told_as_such(pretended, tmp_path, monkeypatch):
    openfoam = pretended("exit 1")
    monkeypatch.setattr(programs.shutil, "disk_usage", lambda path: SimpleNamespace(free=1000))
    with pytest.raises(WriteError, match="No space left"):
        run_program(("simpleFoam",), tmp_path, openfoam)


def test_a_program_that_is_watched_is_ended_with_its_watcher(pretended, tmp_path):
    openfoam = pretended("echo $$ > number; while true; do :; done")

    def watch():
        if (tmp_path / "number").is_file():
            raise RunError("it diverged")

    with pytest.raises(RunError, match="it diverged"):
        run_program(("simpleFoam",), tmp_path, openfoam, watch=watch)
    with pytest.raises(ProcessLookupError):
        os.kill(int((tmp_path / "number").read_text()), signal.SIGTERM)
