"""The simulator: compiled traffic, dynamics, sensors, outcomes, rewards and feasibility of a batch of rows."""
