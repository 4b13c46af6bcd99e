"""Training of methods: what a run directory holds, the training that fills it, and the learning curves read from it."""
