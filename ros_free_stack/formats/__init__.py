"""Motion file formats, one a module: human motion and robot trajectories, in and out."""
