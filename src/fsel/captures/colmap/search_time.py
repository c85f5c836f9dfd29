"""Time limit of the search for frames that a first try did not place."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass, field

MORE, LEAST_MORE = 3.0, 60.0  # times the first try, and seconds, of the search for more frames


@dataclass
class SearchTime:
    """Time of a search for poses, after which what is placed by then is kept.

    Without a limit that a person states, the search for more than the first try places may take
    three times as long, or a minute. The first try is always mapped.
    """

    limit: float | None = None  # seconds in all
    began: float = field(default_factory=time.monotonic, compare=False)
    end: float = field(default=math.inf, compare=False)
    first: bool = field(default=True, compare=False)  # whether the first try is under way

    def __post_init__(self) -> None:
        if self.limit is not None:
            self.end = self.began + self.limit

    @property
    def left(self) -> float:
        """Seconds that are left."""
        return self.end - time.monotonic()

    @property
    def over(self) -> bool:
        """Whether a try for more is to be stopped."""
        return not self.first and self.left <= 0

    def tried(self) -> None:
        """Note that the first try is over."""
        if self.first and self.limit is None:
            now = time.monotonic()
            self.end = now + max(LEAST_MORE, MORE * (now - self.began))
        self.first = False
