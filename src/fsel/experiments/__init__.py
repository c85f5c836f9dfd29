"""The paper's other tables and figures, one module a kind; none is part of the budget sweep."""
