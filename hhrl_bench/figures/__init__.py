"""Figures of leaderboards, analyses and episodes, in one style, and pictures of single episodes."""
