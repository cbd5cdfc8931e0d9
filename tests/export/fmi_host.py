"""A host of FMUs that calls their binary by its address, without any library: FMI 2 and 3."""

import ctypes
import zipfile
from pathlib import Path

import numpy as np

from vvdp.programs.foreign.platforms import this_platform

OK, ERROR = 0, 3
Logger3 = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_int, ctypes.c_char_p, ctypes.c_char_p)
Logger2 = ctypes.CFUNCTYPE(
    None, ctypes.c_void_p, ctypes.c_char_p, ctypes.c_int, ctypes.c_char_p, ctypes.c_char_p, ctypes.c_char_p
)


class Callbacks2(ctypes.Structure):
    """What an instance of FMI 2 is handed; memory is that of the FMU."""

    _fields_ = (("logger", Logger2), ("allocate", ctypes.c_void_p), ("free", ctypes.c_void_p),
                ("finished", ctypes.c_void_p), ("environment", ctypes.c_void_p))  # fmt: skip


def token_of(made):
    """What an FMU is known by."""
    text = made.entries["modelDescription.xml"].decode()
    word = "instantiationToken" if made.fmi == 3 else "guid"
    return text.partition(f'{word}="')[2].partition('"')[0]


class Host:
    """An instance of an FMU; `said` is what it has logged."""

    def __init__(self, made, folder, token=None, has_events=False):
        Path(folder).mkdir(exist_ok=True)
        path = Path(folder, "made.fmu")
        path.write_bytes(made.content)
        with zipfile.ZipFile(path) as file:
            folders = f"binaries/{this_platform().folder(made.fmi)}/"
            (binary,) = [name for name in file.namelist() if name.startswith(folders)]
            self.library = ctypes.CDLL(file.extract(binary, folder))
        self.fmi, self.model = made.fmi, made.model
        names = [each.name for each in made.model.variables]
        self.references = {name: number for number, name in enumerate(names, 1)}
        self.said, self.time, self.has_events = list[str](), 0.0, has_events
        self.instance = self._instance(token_of(made) if token is None else token)

    def _instance(self, token):
        """A new instance of the library; None if it refuses."""
        prefix, name, key = f"fmi{self.fmi}", b"host", token.encode()
        if self.fmi == 3:
            self.logger = Logger3(lambda _, status, category, words: self.said.append(words.decode()))
            create = self.library.fmi3InstantiateCoSimulation
            events = self.has_events
            rest = [name, key, None, False, False, events, events, None, ctypes.c_size_t(0), None, self.logger, None]
        else:
            said = lambda _, own, status, category, form, words: self.said.append(words.decode())  # noqa: E731
            self.logger = Callbacks2(Logger2(said), None, None, None, None)
            create = self.library.fmi2Instantiate
            rest = [name, 1, key, None, ctypes.byref(self.logger), 0, 0]
        create.restype = ctypes.c_void_p
        self.free = getattr(self.library, f"{prefix}FreeInstance")
        return create(*rest)

    def call(self, name, *arguments):
        """The status of a function by its name without the version."""
        return getattr(self.library, f"fmi{self.fmi}{name}")(ctypes.c_void_p(self.instance), *arguments)

    def begin(self, start=0.0, tolerance=None):
        """Initialises; the worst status."""
        zero, wanted = ctypes.c_double(0.0), ctypes.c_double(tolerance or 0.0)
        if self.fmi == 3:
            arguments = (tolerance is not None, wanted, ctypes.c_double(start), False, zero)
            found = [self.call("EnterInitializationMode", *arguments)]
        else:
            found = [self.call("SetupExperiment", int(tolerance is not None), wanted, ctypes.c_double(start), 0, zero)]
            found += [self.call("EnterInitializationMode")]
        return max(*found, self.call("ExitInitializationMode"))

    def set(self, **values):
        """Sets variables by name (`__` for a dot); the status."""
        return self.put({name.replace("__", "."): value for name, value in values.items()})

    def put(self, values):
        """Sets variables; the status."""
        numbers = [self.references.get(name, name) for name in values]
        return self._values("Set", numbers, list(values.values()))[0]

    def get(self, *names):
        """Values of variables."""
        status, values = self._values("Get", [self.references.get(name, name) for name in names], [0.0] * len(names))
        assert status == OK, self.said
        return values

    def _values(self, word, references, values):
        kept = np.array(values, float)
        count = ctypes.c_size_t(len(values))
        numbers = (ctypes.c_uint32 * len(values))(*references)
        address = ctypes.c_void_p(kept.ctypes.data)
        if self.fmi == 3:
            return self.call(f"{word}Float64", numbers, count, address, count), kept
        return self.call(f"{word}Real", numbers, count, address), kept

    def step(self, size, time=None):
        """A step; the status."""
        at = ctypes.c_double(self.time if time is None else time)
        if self.fmi == 3:
            flags, last = [ctypes.c_bool() for _ in range(3)], ctypes.c_double()
            handed = [ctypes.byref(each) for each in (*flags, last)]
            status = self.call("DoStep", at, ctypes.c_double(size), True, *handed)
            self.needs_event, _, self.is_early = (each.value for each in flags)
            if self.has_events:
                self.time = last.value
                return status
        else:
            status = self.call("DoStep", at, ctypes.c_double(size), 1)
        self.time += size if status == OK else 0.0
        return status

    def pass_event(self, clock):
        """Whether a clock ticks at an event, which is then passed, and the time of the next event."""
        assert self.call("EnterEventMode") == OK
        tick, next_time, flags = ctypes.c_bool(), ctypes.c_double(), [ctypes.c_bool() for _ in range(5)]
        one = ctypes.c_size_t(1)
        assert self.call("GetClock", (ctypes.c_uint32 * 1)(clock), one, ctypes.byref(tick)) == OK
        handed = [ctypes.byref(each) for each in (*flags, next_time)]
        assert self.call("UpdateDiscreteStates", *handed) == OK
        assert [each.value for each in flags] == [False] * 4 + [np.isfinite(next_time.value)]
        assert self.call("EnterStepMode") == OK
        return tick.value, next_time.value

    def state(self):
        """The state as bytes."""
        word = "FMUState" if self.fmi == 3 else "FMUstate"
        kept, size = ctypes.c_void_p(), ctypes.c_size_t()
        assert self.call(f"Get{word}", ctypes.byref(kept)) == OK
        assert self.call(f"Serialized{word}Size", kept, ctypes.byref(size)) == OK
        found = ctypes.create_string_buffer(size.value)
        assert self.call(f"Serialize{word}", kept, found, size) == OK
        assert self.call(f"Free{word}", ctypes.byref(kept)) == OK
        return found.raw

    def restore(self, content):
        """Continues from a state as bytes; the status."""
        word, read = ("FMUState", "DeserializeFMUState") if self.fmi == 3 else ("FMUstate", "DeSerializeFMUstate")
        kept = ctypes.c_void_p()
        status = self.call(read, content, ctypes.c_size_t(len(content)), ctypes.byref(kept))
        if status == OK:
            status = self.call(f"Set{word}", kept)
            assert self.call(f"Free{word}", ctypes.byref(kept)) == OK
        return status

    def close(self):
        """Frees the instance."""
        self.free.restype = None
        self.free(ctypes.c_void_p(self.instance))
