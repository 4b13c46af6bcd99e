"""Transfer: a trained run reused in another task in several ways, each beside training from scratch, and its worth."""
