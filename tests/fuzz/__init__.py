"""Damaged captures and odd command lines, drawn from seeds, and what the commands make of them.

PYTHONPATH=src:tests python -m fuzz --cases 20000
"""
