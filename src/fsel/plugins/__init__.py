"""Plugins of other programs, which import them by their entry points: one file each."""
