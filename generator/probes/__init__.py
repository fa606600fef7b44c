"""Kinematic probes: whether a motion does what the words say, from joint positions alone."""
