"""The greedy selector and its scorers (paper, section 3.3)."""
