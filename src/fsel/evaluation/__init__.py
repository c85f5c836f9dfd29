"""Evaluators, runs of methods, and what their picks are worth: the one way to measure."""
