"""The generators, a package each: see `generator.model` for what they have in common."""
