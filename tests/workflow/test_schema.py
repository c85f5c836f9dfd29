"""The schema's lists and the tables of keys follow from the registries."""

from pathlib import Path

import yaml

from fsel.workflow.schema import PAGE, SCHEMA, with_keys, with_names

ROOT = Path(__file__).resolve().parents[2]

SMALL = """\
properties:
  kind:
    description: Which.
    enum: [old]  # none, fsel.ingest.read:POSES
    default: none
  section:
    description: >-
      Two
      lines.
    default: {}
    properties:
      numbers: {description: How many., default: [1, 2]}
      names: {description: Of them., items: {enum: [a, b]}}
$defs:
  dataset:
    properties:
      label: {description: Name.}
  reconstructor:
    properties:
      name: {description: Which., default: old}
"""
HEAD = "| key | default | meaning |\n|---|---|---|\n"


def test_the_schema_and_the_page_are_up_to_date():
    schema = (ROOT / SCHEMA).read_text(encoding="utf-8")
    page = (ROOT / PAGE).read_text(encoding="utf-8")
    hint = "run `python -m fsel.workflow.schema`"
    assert with_names(schema) == schema, hint
    assert with_keys(page, yaml.safe_load(schema)) == page, hint


def test_a_list_is_what_its_comment_names():
    text = with_names(SMALL)
    assert "    enum: [none, layout, colmap, file]  # none, fsel.ingest.read:POSES\n" in text
    assert with_names(text) == text


def test_tables_by_hand():
    page = f"before\n\n{HEAD}| `old` | | |\n\nbetween\n\n{HEAD}\nlast\n\n{HEAD}\nafter\n"
    assert with_keys(page, yaml.safe_load(SMALL)) == (
        f"before\n\n{HEAD}"
        '| `kind` | `"none"` | Which. One of `old`. |\n'
        "| `section` | | Two lines. |\n"
        "| `section.numbers` | `[1, 2]` | How many. |\n"
        "| `section.names` | | Of them. One of `a`, `b`. |\n"
        f"\nbetween\n\n{HEAD}"
        "| `datasets.*.label` | | Name. |\n"
        f"\nlast\n\n{HEAD}"
        '| `reconstruction.name` | `"old"` | Which. |\n'
        "\nafter\n"
    )
