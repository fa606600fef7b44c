"""What ParTY's stages are trained for."""
