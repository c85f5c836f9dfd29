"""Contact sheet: every frame of a capture in one picture, marked by what a selection made of it."""

from __future__ import annotations

from io import BytesIO

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from fsel.pages.shown import ReportContent, cards_of

CELL, TEXT, EDGE = 120, 16, 4  # pixels of a picture's longer side, a line of text, a coloured edge
MOST_ACROSS = 16
COLOURS = {"pick": (213, 94, 0), "held": (0, 114, 178)}
COLOURS |= {"bad": (176, 0, 32), "left": (255, 255, 255)}


def sheet(shown: ReportContent) -> np.ndarray:
    """(h, w, 3) uint8 frames in the order of the capture: picks have an orange edge and their
    order, held-out frames a blue edge, bad ones a red edge."""
    cards = cards_of(shown)
    images = [_picture(shown.pictures.get(card.frame)) for card in cards]
    wide = max(image.shape[1] for image in images) + 2 * EDGE
    high = max(image.shape[0] for image in images) + 2 * EDGE + TEXT
    across = min(MOST_ACROSS, max(1, round(np.sqrt(len(cards) * 1.6 * high / wide))))
    rows = -(-len(cards) // across)
    page = Image.new("RGB", (across * wide, rows * high), "white")
    pen, font = ImageDraw.Draw(page), ImageFont.load_default(11)
    for at, (card, image) in enumerate(zip(cards, images, strict=True)):
        x, y = at % across * wide, at // across * high
        under = (x, y, x + image.shape[1] + 2 * EDGE - 1, y + image.shape[0] + 2 * EDGE - 1)
        pen.rectangle(under, fill=COLOURS[card.kind])
        page.paste(Image.fromarray(image), (x + EDGE, y + EDGE))
        name = f"{card.order}: {card.name}" if card.order else card.name
        pen.text((x + EDGE, y + high - TEXT + 1), _short(name, wide, font), "black", font)
    return np.asarray(page)


def _picture(jpeg: bytes | None) -> np.ndarray:
    if jpeg is None:
        return np.full((CELL * 3 // 4, CELL, 3), 235, np.uint8)
    image = Image.open(BytesIO(jpeg))
    image.thumbnail((CELL, CELL))
    return np.asarray(image.convert("RGB"))


def _short(name: str, width: int, font: ImageFont.FreeTypeFont | ImageFont.ImageFont) -> str:
    """The end of a name that fits a width in pixels."""
    cut = 0
    while font.getlength(("…" if cut else "") + name[cut:]) > width - EDGE and cut < len(name):
        cut += 1
    return ("…" if cut else "") + name[cut:]
