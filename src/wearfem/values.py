"""Values in files: dataclasses, NamedTuples, tuples, arrays and numbers, written to HDF5 and read back to the last bit.

A state is a value, so a restart is reading it. Only classes of wearfem and of the case itself come back: a file cannot name others.
"""

import sys
from dataclasses import fields, is_dataclass
from importlib import import_module
from typing import Any

import h5py
import numpy as np

from wearfem.errors import UserError

KIND = "kind"  # attribute of a group that says what it holds
LARGE = 64  # bytes from which an array is compressed


def write_value(group: h5py.Group, name: str, value: Any) -> None:
    """Write a value under a name. Arrays are compressed and carry a checksum, so that a damaged file is noticed."""
    if isinstance(value, np.ndarray):
        squeeze = (
            {"compression": "gzip", "compression_opts": 1, "fletcher32": True}
            if value.nbytes >= LARGE
            else {}
        )
        group.create_dataset(name, data=value, **squeeze)
        return
    inner = group.create_group(name)
    match value:
        case None:
            inner.attrs[KIND] = "none"
        case bool() | int() | float() | str() | np.generic():
            inner.attrs[KIND] = type(value).__name__
            inner.attrs["value"] = value
        case dict():
            inner.attrs[KIND] = "dict"
            for number, (key, item) in enumerate(value.items()):
                write_value(inner, str(number), (key, item))
        case tuple() | list() if not hasattr(value, "_fields"):
            inner.attrs[KIND] = type(value).__name__
            for number, item in enumerate(value):
                write_value(inner, str(number), item)
        case _ if _names(value) is not None:
            inner.attrs[KIND] = f"{type(value).__module__}:{type(value).__qualname__}"
            for field in _names(value) or ():
                write_value(inner, field, getattr(value, field))
        case _:
            raise TypeError(f"{name} is a {type(value).__name__}, which cannot be written")


def read_value(group: h5py.Group, name: str) -> Any:
    """The value written under a name."""
    inner = group[name]
    if isinstance(inner, h5py.Dataset):
        return np.asarray(inner[()])
    kind = inner.attrs[KIND]
    match kind:
        case "none":
            return None
        case "bool" | "int" | "float" | "str":
            return {"bool": bool, "int": int, "float": float, "str": str}[kind](inner.attrs["value"])
        case "dict":
            return dict(_items(inner))
        case "tuple" | "list":
            return (tuple if kind == "tuple" else list)(_items(inner))
        case _ if ":" in kind:
            made = _class(kind)
            return made(**{field: read_value(inner, field) for field in inner})
        case _:
            return getattr(np, kind)(inner.attrs["value"])


def _items(group: h5py.Group) -> list[Any]:
    return [read_value(group, str(number)) for number in range(len(group))]


def _names(value: Any) -> tuple[str, ...] | None:
    """The fields that make up a value; None for what has none."""
    if is_dataclass(value) and not isinstance(value, type):
        return tuple(field.name for field in fields(value) if field.init)
    return getattr(value, "_fields", None)


def _class(kind: str) -> type:
    """The class of this name, from wearfem or from the case that has been loaded."""
    module, _, name = kind.partition(":")
    if module.startswith("wearfem."):
        home: Any = import_module(module)
    elif module.startswith("wearfem_case_") and module in sys.modules:
        home = sys.modules[module]
    else:
        raise UserError(
            f"a file names the class {kind}, which belongs neither to wearfem nor to the case that was loaded"
        )
    found: Any = home
    for part in name.split("."):
        found = getattr(found, part, None)
    if not isinstance(found, type) or not (is_dataclass(found) or hasattr(found, "_fields")):
        raise UserError(
            f"a file names the class {kind}, which this version does not have: use the version that wrote it"
        )
    return found
