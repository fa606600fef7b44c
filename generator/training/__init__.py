"""Training of the generator's models: one resumable loop, one objective a model."""
