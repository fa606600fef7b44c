"""What becomes of generated frames: joined to given ones, their standing feet held still."""
