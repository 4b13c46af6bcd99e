"""The replay buffer and the ways to draw from it: uniformly, prioritised, hierarchically; multi-step returns."""
