"""Scorers learned from labelled requests: their inputs, how they learn, what they are worth."""
