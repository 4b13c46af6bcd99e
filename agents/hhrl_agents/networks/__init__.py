"""The networks that are learned: what they consist of, their evaluation in a fixed order, and their training.

`architectures`, `arithmetic` and `layers` evaluate, by compiled kernels that give the same bits on every processor. The
other modules train by torch: layers, attention, value networks, and their parameters with the optimiser.
"""
