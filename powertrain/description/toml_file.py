"""Frozen structures from TOML files and back, with errors that name file, key, what was found and what was expected."""

from __future__ import annotations

import json
import re
import tomllib
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import msgspec

from ..errors import VehicleError

if TYPE_CHECKING:
    from collections.abc import Sequence
    from os import PathLike

T = TypeVar("T")


def find(name_or_path: str | PathLike[str], shelf: Path, what: str) -> Path:
    """The file that is meant: a path, or the name of one on `shelf`.

    Raises:
        VehicleError: no such file, and no shipped `what` of that name.
    """
    path = Path(name_or_path)
    if path.suffix or path.is_file():
        return path
    names = on_shelf(shelf)
    if str(name_or_path) not in names:
        raise VehicleError(f"{name_or_path}: no such file and no shipped {what}, expected a TOML file or one of {', '.join(names)}")
    return shelf / f"{name_or_path}.toml"


def on_shelf(shelf: Path) -> list[str]:
    """Names of the TOML files on `shelf`."""
    return sorted(path.stem for path in shelf.glob("*.toml"))


def read_toml(path: Path, kind: type[T]) -> T:
    """A structure of `kind` from a TOML file.

    Raises:
        VehicleError: a file that cannot be read, is not TOML or does not describe a `kind`.
    """
    try:
        table = tomllib.loads(path.read_text(encoding="utf-8-sig"))
    except FileNotFoundError:
        raise VehicleError(f"{path}: no such file") from None
    except (ValueError, RecursionError) as error:
        raise VehicleError(f"{path}: not TOML: {error}") from None
    except OSError as error:
        raise VehicleError(f"{path}: cannot be read: {error.strerror}") from None
    try:
        return msgspec.convert(table, kind)
    except msgspec.ValidationError as error:
        raise VehicleError(f"{path}: {_explain(str(error), table, kind)}") from None


def _explain(message: str, table: dict[str, Any], kind: type) -> str:
    """The validator's message with the key in plain dots, the value that was found and what was expected."""
    text, _, place = message.partition(" - at `$")
    key, words = place.strip("`."), re.findall(r"\w+", place)
    types, value = _types_at(kind, words), _value_at(table, words)
    text = text.replace("`", "")
    if field := re.search(r"field (\w+)", text):
        dotted = f"{key}.{field[1]}" if key else field[1]
        if "unknown" not in text:
            return f"key {dotted} is missing"
        known = [entry for entry in types if isinstance(entry, msgspec.inspect.StructType)]
        if len(known) > 1 and isinstance(value, dict):
            known = [entry for entry in known if entry.tag == value.get(entry.tag_field)]
        allowed = f", expected in {key or 'the file'} only {', '.join(f.encode_name for f in known[0].fields)}" if len(known) == 1 else ""
        return f"unknown key {dotted}{allowed}"
    if choice := re.fullmatch(r"Invalid (?:enum )?value '?(.*?)'?", text):
        return f"{key} is {choice[1]!r}{_choices(types)}"
    if isinstance(value, dict | list) or not text.startswith("Expected"):
        return f"{key}: {text}" if key else text
    return f"{key} is {value!r}, {text[0].lower()}{text[1:]}"


def _value_at(table: dict[str, Any], words: Sequence[str]) -> Any:
    value: Any = table
    for word in words:
        try:
            value = value[int(word)] if isinstance(value, list) else value[word]
        except (KeyError, IndexError, ValueError, TypeError):
            break
    return value


def _choices(types: Sequence[msgspec.inspect.Type]) -> str:
    literal = [str(value) for entry in types if isinstance(entry, msgspec.inspect.LiteralType) for value in entry.values]
    tags = [str(entry.tag) for entry in types if isinstance(entry, msgspec.inspect.StructType) and entry.tag is not None]
    return f", expected {' or '.join(literal or tags)}" if literal or tags else ""


def _types_at(kind: type, words: Sequence[str]) -> list[msgspec.inspect.Type]:
    """What may stand at a key path of a `kind`; the struct itself for the tag of a tagged one."""
    found = [msgspec.inspect.type_info(kind)]
    for word in words:
        after: list[msgspec.inspect.Type] = []
        for entry in found:
            if isinstance(entry, msgspec.inspect.StructType):
                after += [field.type for field in entry.fields if field.encode_name == word]
                after += [entry] if entry.tag_field == word else []
        found = [part for entry in after for part in (entry.types if isinstance(entry, msgspec.inspect.UnionType) else (entry,))]
    return found


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
