"""Programs of other people, or of one's own: their settings, how they are run, and how they end."""
