"""Messages to a page: a description in JSON, then columns of numbers, in the unit in which they are shown.

8 bytes length of the description, the description, padding to 8 bytes, the columns. Times have 64 bits, all others 32.
"""

import json
import struct
from collections.abc import Iterable, Mapping
from typing import Any, Protocol

import numpy as np

from vvdp.base.arrays import Array
from vvdp.report.interactive import Placed, described_chart, is_live
from vvdp.results.chart import Chart
from vvdp.results.result import Table
from vvdp.results.store import finite


class RawColumns:
    """Columns without compression, each once."""

    def __init__(self) -> None:
        self.content = bytearray()
        self.described: list[tuple[int, int, int]] = []
        self._known: dict[tuple[int, bytes], int] = {}

    def place(self, values: Array) -> int:
        """The place of a column in the list; it is added where it is not there yet."""
        rises = values.size > 1 and bool(np.all(np.diff(values) >= 0.0))
        packed = np.ascontiguousarray(values, "<f8" if rises else "<f4")
        content = packed.tobytes()
        key = (packed.itemsize, content)
        if key not in self._known:
            self.content += bytes(-len(self.content) % 8)
            self._known[key] = len(self.described)
            self.described.append((len(self.content), packed.size, packed.itemsize))
            self.content += content
        return self._known[key]


class Describing(Protocol):
    """Content that describes itself, with its numbers among the columns."""

    def describe(self, columns: Placed) -> dict[str, Any]:
        """The description."""


def packet(
    head: Mapping[str, object],
    charts: Iterable[Chart] = (),
    tables: Mapping[str, Table] | None = None,
    **more: Describing | None,
) -> bytes:
    """A description with the charts among `charts` that can be live, and with `more` under its names."""
    columns = RawColumns()
    shown = [described_chart(chart, tables or {}, columns) for chart in charts if is_live(chart)]
    whole = {**head, **{name: each.describe(columns) for name, each in more.items() if each is not None}}
    if shown:
        whole["charts"] = shown
    whole["columns"] = columns.described
    text = json.dumps(finite(whole), allow_nan=False).encode()
    text += b" " * (-len(text) % 8)
    return struct.pack("<Q", len(text)) + text + bytes(columns.content)
