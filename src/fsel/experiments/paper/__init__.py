"""The paper's other tables and figures, one module a kind."""
