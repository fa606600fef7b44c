"""Finding a text's place in a motion, and a motion's texts, in the space that text and motion segments share."""
