"""Building blocks that generators share: layers, quantizer, networks of durations and of the evaluator."""
