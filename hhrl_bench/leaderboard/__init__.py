"""The record of a leaderboard, how it is read and written, and what in it follows from the results of agents."""
