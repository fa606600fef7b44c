"""Motions with texts to train and evaluate on: one protocol for the authored corpus, HumanML3D and KIT-ML."""
