"""Studies beside the paper: speed against error, hard cases, economy, and more."""
