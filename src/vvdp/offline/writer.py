"""The last stage of an estimation: rows and edges on their way to disk; a row waits until its pressure is known."""

from collections.abc import Mapping

import numpy as np

from vvdp.base.arrays import Array
from vvdp.offline.estimate_result import EDGES, FUSED_ROWS, PRESSURE_ROW, ROWS, Store
from vvdp.offline.offline_filter import FilteredRows
from vvdp.offline.sums import Sums


class Writer:
    """Writes rows and edges; with a pressure it keeps their times and angles until that has come."""

    def __init__(self, store: Store, sums: Sums, *, with_pressure: bool, fused: bool) -> None:
        self._store, self._sums, self._with_pressure = store, sums, with_pressure
        self.rows: tuple[Array, Array] | None = None
        """Times and angles of the rows that the pressure is still told of."""
        self._bare = 0  # so many of the last rows still lack their pressure
        more = {**(PRESSURE_ROW if with_pressure else {}), **(FUSED_ROWS if fused else {})}
        store.columns("", {**ROWS, **more})
        store.columns("edges", EDGES)

    def write(self, filtered: FilteredRows) -> None:
        """Writes rows and edges."""
        times = filtered.rows["time"]
        if times.size:
            if self._with_pressure:
                self._remember(filtered.rows)
                self._bare += times.size
            self._store.append("", filtered.rows)
        if filtered.edges:
            self._store.append("edges", filtered.edges)
        self._sums.add(filtered)

    def _remember(self, rows: Mapping[str, Array]) -> None:
        before = self.rows or (np.empty(0), np.empty(0))
        self.rows = np.concatenate([before[0], rows["time"]]), np.concatenate([before[1], rows["angle"]])

    def give_pressure(self, times: Array, values: Array, longest: int, *, last: bool) -> None:
        """Writes the pressure of the rows up to its newest sample; of all rows, if it is the `last`. No more than the
        `longest` of them wait on."""
        assert self.rows is not None
        row_times = self.rows[0]
        begin = row_times.size - self._bare
        end = int(np.searchsorted(row_times, times[-1], side="right")) if times.size else 0
        end = row_times.size if last else max(begin, end, row_times.size - longest)
        rows = row_times[begin:end]
        given = np.interp(rows, times, values, left=np.nan, right=np.nan) if times.size else np.full(rows.size, np.nan)
        self._store.append("", {"inlet_pressure": given})
        self._bare -= rows.size

    def forget_rows(self, until: int) -> None:
        """Forgets the first rows, `until` that number."""
        assert self.rows is not None
        self.rows = self.rows[0][until:], self.rows[1][until:]

    def end_clock(self) -> None:
        """The rows to come are on another clock."""
        self.rows = None
