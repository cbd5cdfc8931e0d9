"""Systems as FMUs, each built once: a model takes a second or two, and so does its binary."""

import hashlib
import os
import shutil
from functools import cache
from pathlib import Path
from unittest.mock import patch

from vvdp.base.files import write_whole
from vvdp.export.fmu import fmu
from vvdp.export.fmu_binary import compile_binary
from vvdp.export.fmu_model import fmu_model
from vvdp.systems.system import load_system

FOLDERS: list[Path] = []
"""Where binaries of these tests lie, for all workers."""


def model_of(name, settings=(), guest=None):
    """The model of a system by its name, for co-simulation; for model exchange if there is a `guest`."""
    return _model_of(name, tuple(settings), guest)


def made(name, fmi, settings=(), guest=None):
    """The FMU of such a model."""
    return _made(name, fmi, tuple(settings), guest)


def built(model, fmi, **others):
    """An FMU; the same sources are compiled once, by the worker that needs them first."""
    with patch("vvdp.export.fmu.compile_binary", _compile_once):
        return fmu(model, fmi, **others)


def _compile_once(sources, flags, target):
    compilers = filter(None, (os.environ.get("CC"), "gcc", "cc", "clang"))
    compiler = next(filter(None, map(shutil.which, compilers)), None)
    words = repr((sorted(sources.items()), flags, target, compiler))
    file = FOLDERS[0] / hashlib.sha256(words.encode()).hexdigest()
    if not file.exists():
        name, binary = compile_binary(sources, flags, target)
        write_whole(file, name.encode() + b"\n" + binary)
    name, _, binary = file.read_bytes().partition(b"\n")
    return name.decode(), binary


@cache
def _model_of(name, settings, guest):
    return fmu_model(load_system(name, settings), guest=guest)


@cache
def _made(name, fmi, settings, guest):
    return built(_model_of(name, settings, guest), fmi)
