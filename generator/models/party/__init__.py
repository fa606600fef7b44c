"""ParTY (Heo et al., CVPR 2026): part tokens are generated first and guide the tokens of the whole body."""
