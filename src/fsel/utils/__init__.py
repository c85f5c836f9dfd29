"""Files, tables, registries, seeds, names and limits: what every part uses."""
