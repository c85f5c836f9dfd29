"""Search, ordering and imitation (paper, sections 3.4 and 3.5)."""
