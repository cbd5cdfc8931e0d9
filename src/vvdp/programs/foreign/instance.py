"""An instance of a foreign FMU in this process: its functions by address, from instantiation to its end.

It needs nothing but the standard library, so that a process of its own begins at once.
"""

import ctypes
import sys
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

OK, WARNING = 0, 1
STATUS = ("OK", "warning", "discard", "error", "fatal", "pending")
NEEDED = {
    2: ("Instantiate", "SetupExperiment", "EnterInitializationMode", "ExitInitializationMode", "SetReal", "GetReal",
        "DoStep", "Terminate", "FreeInstance"),
    3: ("InstantiateCoSimulation", "EnterInitializationMode", "ExitInitializationMode", "SetFloat64", "GetFloat64",
        "DoStep", "Terminate", "FreeInstance"),
}  # fmt: skip
"""The functions that are called, by the version of FMI, without their prefix."""
CALLS = {2: ("SetReal", "DoStep", "GetReal"), 3: ("SetFloat64", "DoStep", "GetFloat64")}
"""The functions of an exchange, in their order."""
_LOGGER2 = ctypes.CFUNCTYPE(
    None, ctypes.c_void_p, ctypes.c_char_p, ctypes.c_int, ctypes.c_char_p, ctypes.c_char_p, ctypes.c_char_p
)
_LOGGER3 = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_int, ctypes.c_char_p, ctypes.c_char_p)


class FmuError(Exception):
    """An FMU cannot be used, or has failed: why, in one sentence."""


@dataclass(frozen=True)
class Plan:
    """The data that an instance is made from: where the FMU was unpacked, and the references of its variables."""

    fmi: int
    binary: str
    resources: str
    identifier: str
    token: str
    inputs: Sequence[int]
    outputs: Sequence[int]
    parameters: Sequence[int]
    values: Sequence[float]

    @property
    def flat(self) -> dict[str, Any]:
        """As JSON has it."""
        return asdict(self)


class _Callbacks2(ctypes.Structure):
    _fields_ = (
        ("logger", _LOGGER2),
        ("allocate", ctypes.c_void_p),
        ("free", ctypes.c_void_p),
        ("finished", ctypes.c_void_p),
        ("environment", ctypes.c_void_p),
    )


class Instance:
    """An instance that is initialised at its first exchange; `said` is the last message of the FMU."""

    def __init__(self, plan: Plan) -> None:
        """Loads the machine code of the FMU. Raises FmuError."""
        self.plan, self.said, self.time = plan, "", 0.0
        try:
            self.library = ctypes.CDLL(plan.binary)
        except OSError as problem:
            raise FmuError(f"its binary cannot be loaded ({problem})") from None
        self.functions = {name: self._function(name) for name in NEEDED[plan.fmi]}
        self.inputs, self.outputs = _references(plan.inputs), _references(plan.outputs)
        self.component = 0

    def _function(self, name: str) -> Any:
        try:
            found = getattr(self.library, f"fmi{self.plan.fmi}{name}")
        except AttributeError:
            raise FmuError(f"its binary has no function fmi{self.plan.fmi}{name}") from None
        found.restype = ctypes.c_void_p if name.startswith("Instantiate") else ctypes.c_int
        return found

    def address(self, name: str) -> int:
        """The address of a function, by its name without the prefix."""
        found = ctypes.cast(self.functions[name], ctypes.c_void_p).value
        assert found is not None
        return found

    def begin(self, time: float, inputs: Sequence[float]) -> list[float]:
        """Instantiates and initialises at a time [s] with these inputs; the outputs there. Raises FmuError."""
        plan, start = self.plan, ctypes.c_double(time)
        create = self.functions[NEEDED[plan.fmi][0]]
        self.component, self._called = _instantiate(plan, create, self._hear)
        if not self.component:
            raise FmuError(self._with_words("it refuses to be instantiated"))
        self.time = time
        self._set(_references(plan.parameters), plan.values)
        none, zero = ctypes.c_int(0), ctypes.c_double(0.0)
        if plan.fmi == 2:
            self._call("SetupExperiment", none, zero, start, none, zero)
            self._call("EnterInitializationMode")
        else:
            self._call("EnterInitializationMode", ctypes.c_bool(), zero, start, ctypes.c_bool(), zero)
        self._set(self.inputs, inputs)
        self._call("ExitInitializationMode")
        return self._outputs()

    def exchange(self, time: float, inputs: Sequence[float]) -> list[float]:
        """Sets the inputs, steps to a time [s], and gives the outputs there. Raises FmuError."""
        self._set(self.inputs, inputs)
        at, step = ctypes.c_double(self.time), ctypes.c_double(time - self.time)
        if self.plan.fmi == 2:
            self._call("DoStep", at, step, ctypes.c_int(1))
        else:
            flags, last = [ctypes.byref(ctypes.c_bool()) for _ in range(3)], ctypes.byref(ctypes.c_double())
            self._call("DoStep", at, step, ctypes.c_bool(True), *flags, last)
        self.time = time
        return self._outputs()

    def close(self) -> None:
        """Ends the instance."""
        if self.component:
            self.functions["Terminate"](ctypes.c_void_p(self.component))
            self.functions["FreeInstance"](ctypes.c_void_p(self.component))
            self.component = 0

    def failure(self, name: str, status: int) -> str:
        """Message for a function whose status ends a run."""
        word = STATUS[status] if 0 <= status < len(STATUS) else str(status)
        return self._with_words(f"fmi{self.plan.fmi}{name} gave the status {word}")

    def _with_words(self, text: str) -> str:
        return f'{text} ("{self.said}")' if self.said else text

    def _call(self, name: str, *arguments: Any) -> None:
        status = self.functions[name](ctypes.c_void_p(self.component), *arguments)
        if status not in (OK, WARNING):
            raise FmuError(self.failure(name, status))

    def _set(self, references: Any, values: Sequence[float]) -> None:
        if len(references):
            count, row = ctypes.c_size_t(len(references)), (ctypes.c_double * len(references))(*values)
            self._call(CALLS[self.plan.fmi][0], references, count, row, *([count] if self.plan.fmi == 3 else []))

    def _outputs(self) -> list[float]:
        count, row = ctypes.c_size_t(len(self.outputs)), (ctypes.c_double * len(self.outputs))()
        self._call(CALLS[self.plan.fmi][2], self.outputs, count, row, *([count] if self.plan.fmi == 3 else []))
        return list(row)

    def _hear(self, words: bytes | None) -> None:
        self.said = (words or b"").decode(errors="replace").strip()[:300]


def _instantiate(plan: Plan, function: Any, hear: Callable[[bytes | None], None]) -> tuple[int, Any]:
    """A component, 0 if it is refused, and its callbacks; `hear` is given its messages."""
    name, key, off = b"vvdp", plan.token.encode(), ctypes.c_bool()
    if plan.fmi == 3:
        logger3, none = _LOGGER3(lambda _, status, category, words: hear(words)), ctypes.c_void_p()
        rest = (off, off, off, off, none, ctypes.c_size_t(0), none, logger3, none)
        return function(name, key, (plan.resources + "/").encode(), *rest) or 0, logger3
    memory = ctypes.CDLL("msvcrt" if sys.platform == "win32" else None)
    logger = _LOGGER2(lambda _, own, status, category, words: hear(words))
    calls = _Callbacks2(logger, *(ctypes.cast(each, ctypes.c_void_p) for each in (memory.calloc, memory.free)))
    zero, folder = ctypes.c_int(0), Path(plan.resources).as_uri().encode()
    return function(name, ctypes.c_int(1), key, folder, ctypes.byref(calls), zero, zero) or 0, calls


def _references(numbers: Sequence[int]) -> Any:
    return (ctypes.c_uint32 * len(numbers))(*numbers)
