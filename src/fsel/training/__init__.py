"""Search, ordering, imitation and refinement (paper, sections 3.4 and 3.5)."""
