"""Schemas of the configuration, and refusals of what does not fit them.

Lists of names follow the registries when schemas are read: in an `enum`, a word such as
`fsel.captures.layouts:LAYOUTS` stands for the names of that registry.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from typing import Any

import yaml
from jsonschema import Draft202012Validator, ValidationError, validators

from fsel.core.registry import closest

REGISTRY = re.compile(r"(fsel(?:\.\w+)+):(\w+)")


class Refusal(SystemExit):
    """A configuration that no job could serve: what is wrong, and what helps.

    It is no `Exception`, so that Snakemake ends with its message alone: wrapped in an error of an
    input function, it would be printed with a traceback.
    """

    def __init__(self, reason: str, hint: str) -> None:
        super().__init__(f"config: {reason}\nHint: {hint}")
        self.reason = reason


class MissingProgram(Refusal):
    """A configuration that could be served where reconstructors' programs were."""


def read_yaml(path: str | Path) -> Any:
    """Read a YAML file, by libyaml where PyYAML has it: ten times as fast."""
    loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
    return yaml.load(Path(path).read_text(encoding="utf-8"), loader)


def read_schema(path: str | Path) -> dict[str, Any]:
    """Return a schema with the names of its registries in their places."""
    found: dict[str, Any] = _with_names(read_yaml(path))
    return found


def _with_names(node: Any, enum: bool = False) -> Any:
    if isinstance(node, dict):
        return {key: _with_names(part, key == "enum") for key, part in node.items()}
    if not isinstance(node, list):
        return node
    if not enum:
        return [_with_names(part) for part in node]
    matches = [(word, REGISTRY.fullmatch(str(word))) for word in node]
    names = [list(getattr(import_module(m[1]), m[2])) if m else [word] for word, m in matches]
    return [name for each in names for name in each]


def complete(values: dict[str, Any], schema: dict[str, Any], hint: str, where: str = "") -> None:
    """Check values against a schema and put its defaults in; a `Refusal` names the key (`where`,
    for the whole), what is wrong, what is allowed, and the hint."""
    try:
        _Filling(schema).validate(values)
    except ValidationError as fault:
        place = fault.json_path.removeprefix("$.").replace("$", where or "top level")
        keys = sorted(fault.schema.get("properties", {}))
        given = fault.instance if isinstance(fault.instance, dict) else [fault.instance]
        allowed = list(map(str, fault.validator_value)) if fault.validator == "enum" else keys
        near = [closest(str(word), allowed) for word in given if word not in allowed]
        meant = "".join(f"did you mean {name!r}? " for name in near if name)
        raise Refusal(
            f"{place}: {fault.message}",
            (meant or (f"the keys here are {keys}; " if keys else "")) + hint,
        ) from fault


def _fill(validator: Any, properties: Any, values: Any, schema: Any) -> Iterator[ValidationError]:
    for key, part in properties.items():
        if "default" in part and isinstance(values, dict):
            values.setdefault(key, part["default"])
    yield from Draft202012Validator.VALIDATORS["properties"](validator, properties, values, schema)


_Filling = validators.extend(Draft202012Validator, {"properties": _fill})
