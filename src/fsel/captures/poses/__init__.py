"""Camera poses of photos and videos by structure from motion, and whether they can be trusted."""
