"""The other tables and figures, one file each; none is part of the budget sweep."""
