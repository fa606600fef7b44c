"""Training of SegMo: batches of tokens, and one objective a stage."""
