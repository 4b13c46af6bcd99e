"""What training has in common whatever the algorithm: environments, exploration, who drives, the base of learners."""
