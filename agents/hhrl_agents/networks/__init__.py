"""The networks that are learned: layers, attention, value networks, and their parameters with the optimiser."""
