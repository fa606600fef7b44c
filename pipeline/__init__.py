"""The composition: the only package that knows every stage, from a sentence to servos."""
