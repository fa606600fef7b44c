"""How good the models are: the metrics of text-to-motion, by this project's evaluator or by the published one."""
