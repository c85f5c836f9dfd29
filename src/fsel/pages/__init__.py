"""Pages to look at, each one HTML file that opens from disk: a selection, a comparison."""
