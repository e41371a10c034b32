"""Frozen structures from TOML files and back, with errors that name file, key, what was found and what was expected."""

from __future__ import annotations

import json
import re
import tomllib
from typing import TYPE_CHECKING, Any, TypeVar

import msgspec

from ..errors import VehicleError

if TYPE_CHECKING:
    from pathlib import Path

T = TypeVar("T")

#: What keys of few possible words may be; the validator's message does not say.
_CHOICES = {"model": "mesc, esc or rc", "extrapolate": "clamp or linear"}


def read_toml(path: Path, kind: type[T]) -> T:
    """A structure of `kind` from a TOML file.

    Raises:
        VehicleError: a file that cannot be read, is not TOML or does not describe a `kind`.
    """
    try:
        table = tomllib.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise VehicleError(f"{path}: no such file") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise VehicleError(f"{path}: not TOML: {error}") from None
    except OSError as error:
        raise VehicleError(f"{path}: cannot be read: {error.strerror}") from None
    try:
        return msgspec.convert(table, kind)
    except msgspec.ValidationError as error:
        raise VehicleError(f"{path}: {_explain(str(error), table)}") from None


def _explain(message: str, table: dict[str, Any]) -> str:
    """The validator's message with the key in plain dots and the value that was found."""
    text, _, place = message.partition(" - at `$")
    key = place.strip("`.")
    field = re.search(r"field `(\w+)`", text)
    if field:
        dotted = f"{key}.{field[1]}" if key else field[1]
        return f"unknown key {dotted}" if "unknown" in text else f"key {dotted} is missing"
    text = text.replace("`", "")
    choice = re.fullmatch(r"Invalid enum value '(.*)'", text)
    if choice:
        return f"{key} is {choice[1]!r}, expected {_CHOICES.get(key.rpartition('.')[2], 'one of the values it may have')}"
    value: Any = table
    for word in re.findall(r"\w+", key):
        try:
            value = value[int(word)] if isinstance(value, list) else value[word]
        except (KeyError, IndexError, ValueError, TypeError):
            break
    if isinstance(value, dict | list) or not text.startswith("Expected"):
        return f"{key}: {text}" if key else text
    return f"{key} is {value!r}, {text[0].lower()}{text[1:]}"


def dump_toml(table: dict[str, Any]) -> str:
    """TOML text of nested tables of numbers, strings and lists; `tomllib` reads it back equal."""
    return "\n".join(_lines(table, "")).strip() + "\n"


def _lines(table: dict[str, Any], prefix: str) -> list[str]:
    plain = {key: value for key, value in table.items() if not isinstance(value, dict) and not _holds_tables(value)}
    lines = [f"{key} = {_value(value)}" for key, value in plain.items()]
    for key, value in table.items():
        if key in plain:
            continue
        name = f"{prefix}{key}"
        if isinstance(value, dict):
            lines += ["", f"[{name}]", *_lines(value, f"{name}.")]
        elif all(isinstance(entry, dict) for entry in value):
            for entry in value:
                lines += ["", f"[[{name}]]", *_lines(entry, f"{name}.")]
        else:
            lines.insert(len(plain), f"{key} = {_value(value)}")
    return lines


def _holds_tables(value: Any) -> bool:
    return isinstance(value, list | tuple) and any(isinstance(entry, dict) for entry in value)


def _value(value: Any) -> str:
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key} = {_value(entry)}" for key, entry in value.items()) + "}"
    if isinstance(value, list | tuple):
        inner = [_value(entry) for entry in value]
        if any(isinstance(entry, list | tuple) for entry in value):
            return "[\n" + "".join(f"    {entry},\n" for entry in inner) + "]"
        return "[" + ", ".join(inner) + "]"
    return json.dumps(value, ensure_ascii=False) if isinstance(value, str) else repr(value)
