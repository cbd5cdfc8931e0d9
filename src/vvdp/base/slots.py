"""Tables that stand inside of others: of which class one may be."""

import types
import typing
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any, get_args, get_origin, get_type_hints

from vvdp.base.params import Params, default_values, field_kinds, field_names


@dataclass(frozen=True)
class TableSlot:
    """A place for a table: of one of several classes, distinguished by their keys; or none, where it is optional."""

    classes: tuple[type[Params], ...]
    optional: bool

    def choice(self, keys: Mapping[str, object]) -> type[Params]:
        """The class that has most of the keys, the first one at a tie."""
        return max(self.classes, key=lambda cls: len(keys.keys() & set(field_names(cls))))


def slot_of(hint: Any) -> TableSlot | None:
    """The slot that an annotation describes, `Triangle | OwnCycle | None`; None if it is not one of a table."""
    members = get_args(hint) if get_origin(hint) in (types.UnionType, typing.Union) else (hint,)
    classes = tuple(c for c in members if isinstance(c, type) and issubclass(c, Params))
    if not classes or len(classes) + (type(None) in members) != len(members):
        return None
    return TableSlot(classes, type(None) in members)


def inner_slots(cls: type) -> dict[str, TableSlot]:
    """The fields of a parameter class that are tables of their own, by name."""
    return _inner_slots(cls)


@cache
def _inner_slots(cls: type) -> dict[str, TableSlot]:
    hints, usual = get_type_hints(cls), default_values(cls)
    open_fields = {name: slot_of(hints[name]) for name, kind in field_kinds(cls).items() if kind is None}
    return {name: TableSlot(slot.classes, slot.optional or name in usual) for name, slot in open_fields.items() if slot}
