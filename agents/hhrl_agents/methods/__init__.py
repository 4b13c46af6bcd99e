"""The learning methods as data: the list of them, what a method consists of, and the hyperparameters of algorithms."""
