"""The models of text-to-motion: tokenizer, mask transformer, residual transformer, durations."""
