"""Tables in the cache: read where nothing they depend on has changed, made anew otherwise."""

import os

import numpy as np
import pytest

from vvdp.simulation import table_cache
from vvdp.simulation.table_cache import kept_table, table_key

TABLE = np.arange(6.0).reshape(2, 3)


def refuses():
    pytest.fail("made although it is there")


def test_read_where_it_was_made(tmp_path):
    key = table_key("code", TABLE)
    kept_table(key, lambda: TABLE, tmp_path)
    np.testing.assert_array_equal(kept_table(key, refuses, tmp_path), TABLE)


def test_key_sees_code_numbers_and_shape():
    keys = {
        table_key("code", TABLE),
        table_key("other code", TABLE),
        table_key("code", TABLE + np.eye(2, 3) * 1e-12),
        table_key("code", TABLE.reshape(3, 2)),
        table_key("code", TABLE, TABLE),
    }
    assert len(keys) == 5


@pytest.mark.parametrize("damage", [lambda old: old[:-1], lambda old: old[:-1] + b"\x01", lambda old: b""])
def test_damaged_is_made_anew(tmp_path, damage):
    kept_table("key", lambda: TABLE, tmp_path)
    (path,) = (tmp_path / table_cache.FOLDER).iterdir()
    path.write_bytes(damage(path.read_bytes()))
    np.testing.assert_array_equal(kept_table("key", lambda: TABLE + 1.0, tmp_path), TABLE + 1.0)
    np.testing.assert_array_equal(kept_table("key", refuses, tmp_path), TABLE + 1.0)


def test_made_each_time_where_nothing_can_be_kept(tmp_path):
    place = tmp_path / "file"
    place.write_text("no folder")
    for offset in (0.0, 1.0):
        np.testing.assert_array_equal(kept_table("key", lambda offset=offset: TABLE + offset, place), TABLE + offset)


def test_oldest_make_room(tmp_path, monkeypatch):
    monkeypatch.setattr(table_cache, "MOST", 3)
    for number in range(5):
        kept_table(f"key{number}", lambda: TABLE, tmp_path)
        os.utime(tmp_path / table_cache.FOLDER / f"key{number}.table", (number, number))
    assert sorted(path.stem for path in (tmp_path / table_cache.FOLDER).iterdir()) == ["key2", "key3", "key4"]
