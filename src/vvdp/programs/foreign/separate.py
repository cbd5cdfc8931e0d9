"""A foreign FMU in a process of its own: a crash of the FMU ends that process, and no other.

Both sides speak in packets: a length, then JSON or numbers. It is no sandbox: the process has the rights of its user.
"""

import json
import os
import signal
import struct
import subprocess
import sys
from collections.abc import Sequence
from contextlib import suppress
from typing import IO

from vvdp.programs.foreign.instance import FmuError, Instance, Plan


class Separate:
    """An FMU in a child process, with the calls of `Instance`."""

    def __init__(self, plan: Plan) -> None:
        """Begins the process, which loads the FMU. Raises FmuError."""
        words = [sys.executable, "-m", "vvdp.programs.foreign.separate"]
        self.child = subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        self._ask(json.dumps(plan.flat).encode())

    def begin(self, time: float, inputs: Sequence[float]) -> list[float]:
        """As of `Instance`."""
        return self.exchange(time, inputs)

    def exchange(self, time: float, inputs: Sequence[float]) -> list[float]:
        """As of `Instance`; the first one begins."""
        answer = self._ask(struct.pack(f"<{len(inputs) + 1}d", time, *inputs))
        return list(struct.unpack(f"<{len(answer) // 8}d", answer))

    def _ask(self, packet: bytes) -> bytes:
        """The answer to a packet. Raises FmuError where the FMU fails or its process has ended."""
        assert self.child.stdin and self.child.stdout
        try:
            _write(self.child.stdin, packet)
            answer = _read(self.child.stdout)
        except (OSError, ValueError):
            answer = None
        if answer is None:
            raise FmuError(self._end_words())
        if answer[:1] != b"+":
            raise FmuError(answer[1:].decode(errors="replace"))
        return answer[1:]

    def _end_words(self) -> str:
        self.close()
        code = self.child.returncode
        if code < 0:
            return f"its process crashed ({signal.Signals(-code).name})"
        return f"its process ended with the code {code}"

    def close(self) -> None:
        """Ends the process."""
        for stream in (self.child.stdin, self.child.stdout):
            with suppress(OSError):
                if stream:
                    stream.close()
        try:
            self.child.wait(2.0)
        except subprocess.TimeoutExpired:
            self.child.kill()
            self.child.wait()


def _write(stream: IO[bytes], packet: bytes) -> None:
    stream.write(struct.pack("<i", len(packet)) + packet)
    stream.flush()


def _read(stream: IO[bytes]) -> bytes | None:
    """The next packet; None at the end."""
    head = stream.read(4)
    if len(head) < 4:
        return None
    (size,) = struct.unpack("<i", head)
    packet = stream.read(size)
    return packet if len(packet) == size else None


def main() -> None:
    """Serves one FMU until the other side closes."""
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what the FMU prints is no answer
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    instance = None
    while (packet := _read(sys.stdin.buffer)) is not None:
        try:
            answer = b""
            if instance is None:
                instance, step = Instance(Plan(**json.loads(packet))), None
            else:
                time, *inputs = struct.unpack(f"<{len(packet) // 8}d", packet)
                step = instance.begin if step is None else instance.exchange
                answer = struct.pack(f"<{len(instance.outputs)}d", *step(time, inputs))
            _write(answers, b"+" + answer)
        except FmuError as problem:
            _write(answers, b"-" + str(problem).encode())
    if instance is not None:
        instance.close()


if __name__ == "__main__":
    main()
