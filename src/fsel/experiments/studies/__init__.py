"""Studies beside the paper: speed against error, and hard cases."""
