"""Configurations from files, or from the keywords of a call."""

import json
import os
import re
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from . import _piste
from .errors import ConfigError
from .tables import WEEK, columns_of, is_table

# Keywords of a sensor may be given next to it: replay(imu=frame, sensor="xsens_mt9a").
LOGS = ("imu", "gnss", "attitude", "reference", "odometer", "barometer", "heading")
SHORT = {"sensor": "imu", "lever_arm": "gnss"}


def configuration(
    source: str | os.PathLike[str] | None, keywords: Mapping[str, Any]
) -> tuple[_piste.Configuration, int | None]:
    """A configuration, and the GPS week of its tables if it is known. `source`: a file, or None for keywords alone."""
    if source is not None and not isinstance(source, str | os.PathLike):
        raise ConfigError(
            f"a configuration file is expected first, not a {type(source).__name__}; tables go by keyword, such as `imu=`",
            "config",
        )
    if source is not None and not keywords:
        return _piste.Configuration.load(os.fspath(source)), None
    if not keywords:
        raise ConfigError("give a configuration file, or its keys as keywords", "keywords")
    keys = {key: value for key, value in keywords.items() if value is not None}
    spelled: dict[str, str] = {}  # the keywords of keys with another path
    for owner in LOGS:
        if owner in keys:
            if isinstance(keys[owner], str | os.PathLike):
                spelled[f"{owner}.file"] = owner
            keys[owner] = _entries(owner, keys[owner])
    for short, owner in SHORT.items():
        if short not in keys:
            continue
        spelled[f"{owner}.{short}"] = short
        value = keys.pop(short)
        entry = keys.get(owner)
        if entry is None:
            raise ConfigError(f"`{short}` belongs to `{owner}`, which is missing", short)
        if isinstance(entry, list):
            right = f"{owner}=[{{'file': …, '{short}': …}}, …]"
            raise ConfigError(f"`{short}` belongs to one of several; state it for each: {right}", short)
        entry = {"file": entry} if is_table(entry) else dict(entry)
        keys[owner] = {**entry, short: value}
    if source is not None:
        keys = {"base": os.path.abspath(os.fspath(source)), **keys}
    tables: dict[str, dict[str, np.ndarray]] = {}
    weeks: dict[str, int] = {}
    text = "".join(_lines(_plain(keys, "", tables, weeks), 0))
    first = min(weeks.values(), default=0)
    for name, week in weeks.items():  # all times count from the week of the first
        if week != first and "time_s" in tables[name]:
            tables[name]["time_s"] = tables[name]["time_s"] + (week - first) * WEEK
    return _piste.Configuration.parse(text, "keywords", tables, spelled), first if weeks else None


def _entries(owner: str, value: Any) -> Any:
    """The value of a log's key, in which a path may stand for a mapping with a `file`, alone or in a list."""
    if isinstance(value, str | os.PathLike):
        return {"file": value}
    if is_table(value) or isinstance(value, Mapping):
        return value
    if isinstance(value, list | tuple):
        return [_entries(owner, entry) for entry in value]
    raise ConfigError(
        f"`{owner}` is a {type(value).__name__}; a file, a mapping, or a table whose columns have names is expected",
        owner,
    )


def _plain(value: Any, path: str, tables: dict[str, dict[str, np.ndarray]], weeks: dict[str, int]) -> Any:
    """The value with its tables replaced by their names."""
    if is_table(value):
        name = path.removesuffix(".file")
        tables[name], week = columns_of(value, name)
        if week is not None:
            weeks[name] = week
        return name if path.endswith(".file") else {"file": name}
    if isinstance(value, Mapping):
        return {str(k): _plain(v, f"{path}.{k}" if path else str(k), tables, weeks) for k, v in value.items()}
    if isinstance(value, os.PathLike):
        return os.path.abspath(value)
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, Sequence | np.ndarray) and not isinstance(value, str):
        return [_plain(v, f"{path}[{i}]", tables, weeks) for i, v in enumerate(value)]
    return value


def _lines(keys: Mapping[str, Any], depth: int) -> list[str]:
    """YAML, with one key a line."""
    lines = []
    for name, value in keys.items():
        key = _scalar(name)
        if isinstance(value, Mapping) and value:
            lines += [f"{'  ' * depth}{key}:\n", *_lines(value, depth + 1)]
        elif isinstance(value, list) and any(isinstance(v, Mapping) for v in value):
            if not all(isinstance(v, Mapping) for v in value):
                raise ConfigError(f"`{name}` is a list of mappings and of other things; mappings are expected", name)
            lines.append(f"{'  ' * depth}{key}:\n")
            for entry in value:
                inner = "".join(_lines(entry, depth + 2)) or "{}\n"
                lines.append("  " * (depth + 1) + "- " + inner.lstrip())
        else:
            lines.append(f"{'  ' * depth}{key}: {_scalar(value)}\n")
    return lines


def _scalar(value: Any) -> str:
    if isinstance(value, list):
        return "[" + ", ".join(_scalar(v) for v in value) + "]"
    plain = isinstance(value, str) and re.fullmatch(r"[\w./+-][\w./+ ()^*-]*", value) and value == value.strip()
    if plain and value.lower() not in ("true", "false", "null", "yes", "no", "on", "off"):
        return value
    return json.dumps(value, ensure_ascii=False)
