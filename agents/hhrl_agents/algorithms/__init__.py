"""The algorithms: the learner of each, found by the name in its config, and the errors that values are learned from."""
