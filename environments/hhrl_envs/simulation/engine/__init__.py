"""What the simulator runs on: compilation, the layout of its memory, random streams and threads."""
