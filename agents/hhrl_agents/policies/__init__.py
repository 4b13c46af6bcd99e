"""The policies that training leaves behind: the agents that act, what they remember, and their checkpoint files."""
