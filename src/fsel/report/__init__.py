"""Summaries with intervals, LaTeX tables, figures."""
