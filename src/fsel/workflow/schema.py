"""Lists of names in the config's schema, and the tables of its keys, from the registries.

    python -m fsel.workflow.schema

rewrites both. In the schema, a list that follows a registry is one line that says so:

    enum: [auto, colmap, nerfstudio]  # auto, fsel.layouts:LAYOUTS

Words without a colon stand for themselves.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping
from importlib import import_module
from pathlib import Path

import yaml

SCHEMA = Path("workflow/schemas/config.schema.yaml")
PAGE = Path("config/README.md")
LIST = re.compile(r"^( *enum: )\[.*\]  # (.*:.*)$", re.M)
HEAD = "| key | default | meaning |\n|---|---|---|\n"
TABLE = re.compile(re.escape(HEAD) + r"(?:\|.*\n)*")


def with_names(schema: str) -> str:
    """The schema's text with every list of names as its registry has it."""

    def listed(found: re.Match) -> str:
        words: list[str] = []
        for part in found[2].split(", "):
            module, _, attribute = part.partition(":")
            words += getattr(import_module(module), attribute) if attribute else [part]
        return f"{found[1]}[{', '.join(words)}]  # {found[2]}"

    return LIST.sub(listed, schema)


def with_keys(page: str, schema: Mapping) -> str:
    """The page's text with its tables of keys: the config's, a dataset's, a reconstructor's."""
    parts = schema["$defs"]
    tables = [
        _table(schema, ""),
        _table(parts["dataset"], "datasets.*."),
        _table(parts["reconstructor"], "reconstruction."),
    ]
    found = iter(tables)
    return TABLE.sub(lambda _: next(found), page)


def _table(node: Mapping, path: str) -> str:
    return HEAD + "".join(f"{row}\n" for row in _rows(node, path))


def _rows(node: Mapping, path: str) -> Iterator[str]:
    """One row a key, those of a section after it."""
    for key, entry in node.get("properties", {}).items():
        yield f"| `{path}{key}` |{_default(entry)} | {_meaning(entry)} |"
        yield from _rows(entry, f"{path}{key}.")


def _default(entry: Mapping) -> str:
    """The cell of a key's default; empty for sections and mappings of names."""
    if "default" not in entry or "properties" in entry or "additionalProperties" in entry:
        return ""
    return f" `{json.dumps(entry['default'])}`"


def _meaning(entry: Mapping) -> str:
    text = " ".join(entry["description"].split())
    allowed = entry.get("enum") or entry.get("items", {}).get("enum")
    return f"{text} One of {', '.join(f'`{name}`' for name in allowed)}." if allowed else text


def main() -> None:
    """Rewrite the schema and the page, in the repository's root."""
    schema = with_names(SCHEMA.read_text(encoding="utf-8"))
    SCHEMA.write_text(schema, encoding="utf-8")
    page = with_keys(PAGE.read_text(encoding="utf-8"), yaml.safe_load(schema))
    PAGE.write_text(page, encoding="utf-8")


if __name__ == "__main__":
    main()
