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
    three times as long, or a minute, and so may the global mapper in the first, whose calibration
    of a repeated pattern takes minutes: another one maps it then.
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
    def stop(self) -> float:
        """The time, as of `time.monotonic`, at which a global mapper that starts now is stopped."""
        if not self.first:
            return self.end
        return self._more() if self.limit is None else max(self.end, self._more())

    def tried(self) -> None:
        """Note that the first try is over."""
        if self.first and self.limit is None:
            self.end = self._more()
        self.first = False

    def _more(self) -> float:
        now = time.monotonic()
        return now + max(LEAST_MORE, MORE * (now - self.began))
