"""Numbers for people: summaries with intervals, LaTeX tables, figures."""
