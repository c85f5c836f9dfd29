"""Frame health: what makes a frame bad for a reconstruction, from arrays alone."""
