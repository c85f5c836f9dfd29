"""Parts that the pages share: a document with its styles and scripts, pictures, choices."""

from __future__ import annotations

import base64
import json
from collections.abc import Iterable
from html import escape
from importlib.resources import files

ROOM = files("fsel.pages")
RADIO = '<label><input type="radio" name="{name}" value="{value}"{checked}> {text}</label>'


def document(title: str, sources: Iterable[str], body: Iterable[str]) -> str:
    """Return a page that needs no other file: HTML with this room's .css and .js `sources`."""
    texts = {name: (ROOM / name).read_text(encoding="utf-8") for name in ("base.css", *sources)}
    styles = "".join(text for name, text in texts.items() if name.endswith(".css"))
    scripts = [f"<script>{text}</script>" for name, text in texts.items() if name.endswith(".js")]
    return "\n".join([head(title, styles), *body, *scripts, "</body></html>"])


def head(title: str, styles: str) -> str:
    """Return a page until its body begins, with a title in plain text and CSS."""
    return (
        '<!doctype html><html lang="en"><head><meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{escape(title)}</title><style>{styles}</style></head><body>"
    )


def data(name: str, content: object) -> str:
    """Return the JSON that the page's scripts find by the name of its element."""
    text = json.dumps(content, separators=(",", ":"), ensure_ascii=False).replace("<", "\\u003c")
    return f'<script type="application/json" id="{name}">{text}</script>'


def source(jpeg: bytes) -> str:
    """Return the address of a JPEG file within the page."""
    return f"data:image/jpeg;base64,{base64.b64encode(jpeg).decode('ascii')}"


def choices(name: str, legend: str, options: Iterable[tuple[str, str]]) -> str:
    """Return the radio buttons, (value, text) each, the first chosen; scripts show them."""
    buttons = [
        RADIO.format(name=name, value=escape(value), text=text, checked="" if at else " checked")
        for at, (value, text) in enumerate(options)
    ]
    return f'<fieldset id="{name}" hidden><legend>{legend}</legend>{"".join(buttons)}</fieldset>'
