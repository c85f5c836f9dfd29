"""Scorers with other inputs or of another kind (paper, Appendix D)."""
