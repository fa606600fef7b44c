"""What words for actions are made of; the words themselves stand with each action."""
