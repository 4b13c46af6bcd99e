"""Analysis: what an agent decides, attends to and is rewarded for, from every step of its test episodes."""
