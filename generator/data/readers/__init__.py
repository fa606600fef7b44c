"""Readers of published motion formats: each gives joint positions in this project's frame and units."""
