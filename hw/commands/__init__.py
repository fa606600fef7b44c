"""The `servos` commands: look at servos, set them up, make them safe."""
