"""The instances of foreign FMUs that runs exchange values with, and the compiled call of each.

Compiled code calls one function, `native`, with the handle of an instance. That is the number of a slot: 20 words with
the address of the code that carries the exchange out, the component, and the addresses of the FMU's own functions.
Code that is trusted is called there and then, without Python; the process of an FMU that is not is spoken to by Python.
"""

import ctypes
import threading
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from vvdp.base.errors import ConfigError, Fault
from vvdp.programs.foreign.instance import CALLS, Instance, Plan
from vvdp.programs.foreign.separate import Separate
from vvdp.simulation.exchange import OUTSIDE, SYMBOL

MOST_SLOTS = 65_536
CODE, COMPONENT, SET, STEP, GET, IN, IN_COUNT, OUT, OUT_COUNT, STATUS, TIME = range(11)
TOLD, WORDS = 11, 20
"""Words of a slot; behind the time, room for what FMI 3 reports a step."""
FAILED = -1
"""The status of a slot whose instance failed in Python; otherwise 16 * (number of the call, from 1) + FMI status."""
_Begin = ctypes.CFUNCTYPE(
    ctypes.c_double, *[ctypes.c_double] * 2, *[ctypes.c_void_p, ctypes.c_int64] * 2,
)  # fmt: skip
_Exchange = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_double, ctypes.c_void_p, ctypes.c_void_p)


@dataclass(frozen=True)
class Foreign:
    """A foreign FMU in its place: `plan` unpacks it and returns the data for its calls; raises ParameterError.

    With `is_single` each instance needs a process of its own, trusted or not.
    """

    name: str
    path: Path
    plan: Callable[[], Plan]
    is_single: bool = False


KNOWN: dict[float, Foreign] = {}
"""The FMUs of drawn circuits by their keys."""
TRUSTED: set[Path] = set()
"""The FMUs whose machine code may run in this process."""


class Slot:
    """An instance with the words that compiled code reads; `trouble` is why it failed."""

    def __init__(self, foreign: Foreign) -> None:
        self.foreign, self.trouble, self.time = foreign, "", 0.0
        self.words = np.zeros(WORDS, np.int64)
        self.words[CODE] = _native()["idle"]
        self.instance: Instance | Separate | None = None
        self.call = _Exchange(self._exchange)

    def begin(self, t: float, inputs: Any, outputs: Any) -> None:
        """Starts the instance and gives its first outputs, NaN if it fails."""
        self.words[OUT_COUNT] = outputs.size
        outputs[:] = np.nan
        try:
            plan = self.foreign.plan()
            self.words[IN_COUNT] = len(plan.inputs)
            is_inside = self.foreign.path in TRUSTED and not self.foreign.is_single
            self.instance = (Instance if is_inside else Separate)(plan)
            outputs[:] = self.instance.begin(t, inputs[: len(plan.inputs)].tolist())
        except BaseException as problem:  # nothing may leave a call from compiled code
            self._fail(problem, t)
            return
        self.words[TIME] = np.float64(t).view(np.int64)
        if isinstance(self.instance, Separate):
            self.words[CODE] = ctypes.cast(self.call, ctypes.c_void_p).value or 0
            return
        self.words[CODE], self.words[COMPONENT] = _native()[f"fmi{plan.fmi}"], self.instance.component
        self.words[SET : GET + 1] = [self.instance.address(name) for name in CALLS[plan.fmi]]
        self.words[[IN, OUT]] = [ctypes.addressof(each) for each in (self.instance.inputs, self.instance.outputs)]

    def _exchange(self, _: int, t: float, inputs: int, outputs: int) -> None:
        given, found = _row(inputs, self.words[IN_COUNT]), _row(outputs, self.words[OUT_COUNT])
        found[:] = np.nan
        if self.trouble:
            return
        try:
            assert self.instance is not None
            found[:] = self.instance.exchange(t, given.tolist())
            self.words[TIME] = np.float64(t).view(np.int64)
        except BaseException as problem:
            self._fail(problem, t)

    def _fail(self, problem: BaseException, t: float) -> None:
        why = "interrupted" if isinstance(problem, KeyboardInterrupt) else str(problem)
        self.words[CODE], self.words[STATUS] = _native()["idle"], FAILED
        self.trouble = self.sentence(t, why)

    def sentence(self, t: float, why: str) -> str:
        """Message for a failure at a time [s]; `why` is its cause."""
        return f"program {self.foreign.name!r}: the FMU {self.foreign.path.name} failed at t = {t:.6g} s: {why}"

    def why(self) -> str:
        """Why the instance failed; empty if it has not."""
        status = int(self.words[STATUS])
        if status > 0 and isinstance(self.instance, Instance):
            name, time = CALLS[self.instance.plan.fmi][status // 16 - 1], self.words[TIME : TIME + 1].view(np.float64)
            return self.sentence(float(time[0]), self.instance.failure(name, status % 16))
        return self.trouble

    def close(self) -> None:
        """Ends the instance; one that has failed is not called again."""
        if self.instance is not None and not (self.words[STATUS] and isinstance(self.instance, Instance)):
            self.instance.close()


_slots: dict[int, Slot] = {}
_table = np.zeros(MOST_SLOTS, np.int64)
_lock = threading.Lock()


def slot_of(handle: float) -> Slot | None:
    """The instance of a handle."""
    return _slots.get(int(handle))


def release(handle: float) -> None:
    """Ends the instance of a handle."""
    with _lock:
        slot = _slots.pop(int(handle), None)
        _table[int(handle)] = 0
    if slot is not None:
        slot.close()


def _begin(key: float, t: float, inputs: int, n: int, outputs: int, m: int) -> float:
    """Starts an instance of the FMU with a key; its handle, the lowest that is free."""
    slot = Slot(KNOWN[key])
    with _lock:
        handle = next((each for each in range(1, MOST_SLOTS) if each not in _slots), 0)
        _slots[handle], _table[handle] = slot, slot.words.ctypes.data
    slot.begin(t, _row(inputs, n), _row(outputs, m))
    return float(handle)


_BEGIN = _Begin(_begin)


def _row(address: int, count: int) -> Any:
    return np.ctypeslib.as_array((ctypes.c_double * int(count)).from_address(address))


def register(key: float, foreign: Foreign) -> None:
    """Makes an FMU known to compiled code by its key."""
    KNOWN[key] = foreign
    OUTSIDE[SYMBOL] = lambda: _native()[SYMBOL]


def trust(path: Path) -> None:
    """Lets the machine code of an FMU run in this process. Raises ConfigError if no drawn circuit uses it."""
    found = path.resolve()
    if found not in {foreign.path for foreign in KNOWN.values()}:
        raise ConfigError([Fault("--trust", 0, str(path), "no program of the system uses this FMU")])
    TRUSTED.add(found)


@cache
def _native() -> dict[str, int]:
    """The addresses of the compiled functions: that which steps call, and what carries exchanges out."""
    from vvdp.generator import binding  # llvmlite is loaded where something is to run

    text = "\n".join([_DISPATCH, _FILL, *(_exchange_text(fmi) for fmi in (2, 3))])
    loaded = binding.load_code(binding.compile_text(text), [SYMBOL, "fmi2", "fmi3", "idle"])
    _KEPT.append(loaded)
    return loaded.addresses


_KEPT: list[Any] = []
_DISPATCH = f"""\
define double @{SYMBOL}(double %key, double %handle, double %t, ptr %in, i64 %n, ptr %out, i64 %m) {{
  %number = fptosi double %handle to i64
  %new = icmp eq i64 %number, 0
  br i1 %new, label %begin, label %go
begin:
  %start = inttoptr i64 {ctypes.cast(_BEGIN, ctypes.c_void_p).value} to ptr
  %made = call double %start(double %key, double %t, ptr %in, i64 %n, ptr %out, i64 %m)
  ret double %made
go:
  %table = inttoptr i64 {_table.ctypes.data} to ptr
  %place = getelementptr ptr, ptr %table, i64 %number
  %slot = load ptr, ptr %place
  %code = load ptr, ptr %slot
  call void %code(ptr %slot, double %t, ptr %in, ptr %out)
  ret double %handle
}}"""
_FILL = f"""\
define void @idle(ptr %slot, double %t, ptr %in, ptr %out) {{
  %place = getelementptr i64, ptr %slot, i64 {OUT_COUNT}
  %count = load i64, ptr %place
  br label %next
next:
  %i = phi i64 [ 0, %0 ], [ %more, %fill ]
  %done = icmp sge i64 %i, %count
  br i1 %done, label %end, label %fill
fill:
  %at = getelementptr double, ptr %out, i64 %i
  store double 0x7FF8000000000000, ptr %at
  %more = add i64 %i, 1
  br label %next
end:
  ret void
}}"""


def _exchange_text(fmi: int) -> str:
    """The LLVM text of an exchange with an FMU of this version: set inputs, step to `t`, get outputs."""
    words = {"component": COMPONENT, "set": SET, "step": STEP, "get": GET, "refs": IN, "count": IN_COUNT,
             "shown": OUT, "shown_count": OUT_COUNT}  # fmt: skip
    lines = [f"define void @fmi{fmi}(ptr %slot, double %t, ptr %in, ptr %out) {{"]
    for name, word in words.items():
        kind = "i64" if name.endswith("count") else "ptr"
        lines += [
            f"  %{name}_at = getelementptr i64, ptr %slot, i64 {word}",
            f"  %{name} = load {kind}, ptr %{name}_at",
        ]
    lines += [f"  %time_at = getelementptr i64, ptr %slot, i64 {TIME}", "  %time = load double, ptr %time_at"]
    lines += [f"  %status_at = getelementptr i64, ptr %slot, i64 {STATUS}", "  %h = fsub double %t, %time"]
    told = [f"%told{i}" for i in range(4)]
    lines += [f"  {each} = getelementptr i64, ptr %slot, i64 {TOLD + i}" for i, each in enumerate(told)]
    again = {name: f", i64 %{name}" if fmi == 3 else "" for name in ("count", "shown_count")}
    flags = "i1 zeroext true, " + ", ".join(f"ptr {each}" for each in told) if fmi == 3 else "i32 1"
    calls = [
        f"%set(ptr %component, ptr %refs, i64 %count, ptr %in{again['count']})",
        f"%step(ptr %component, double %time, double %h, {flags})",
        f"%get(ptr %component, ptr %shown, i64 %shown_count, ptr %out{again['shown_count']})",
    ]
    lines += ["  %none = icmp eq i64 %count, 0", "  br i1 %none, label %call2, label %call1"]
    for number, call in enumerate(calls, 1):
        lines += [f"call{number}:", f"  %found{number} = call i32 {call}"]
        lines += [f"  %bad{number} = icmp ugt i32 %found{number}, 1"]
        lines += [f"  br i1 %bad{number}, label %fail, label %call{number + 1}"]
    found = ", ".join(f"[ %found{i}, %call{i} ]" for i in (1, 2, 3))
    base = ", ".join(f"[ {16 * i}, %call{i} ]" for i in (1, 2, 3))
    lines += ["call4:", "  store double %t, ptr %time_at", "  ret void"]
    lines += ["fail:", f"  %found = phi i32 {found}", f"  %base = phi i64 {base}", "  %wide = zext i32 %found to i64"]
    lines += [
        "  %status = add i64 %base, %wide",
        "  store double %t, ptr %time_at",
        "  store i64 %status, ptr %status_at",
    ]
    lines += [
        "  store i64 ptrtoint (ptr @idle to i64), ptr %slot",
        "  call void @idle(ptr %slot, double %t, ptr %in, ptr %out)",
    ]
    return "\n".join([*lines, "  ret void", "}"])
