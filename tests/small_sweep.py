"""Settings of a sweep that is over in seconds."""

SEARCH = {
    "labeller": "genetic",
    "k": 4,
    "population": 6,
    "farthest": 2,
    "uniform": 2,
    "generations": 1,
    "elites": 1,
    "tournament": 2,
    "crossover": 0.8,
    "mutation": 0.3,
    "evaluations": 5,
    "stored": 5,
    "kept": 2,
}
RECONSTRUCTION = {"name": "splats", "long_side": 32, "settings": {}}
