"""Pictures of a row, and a window that shows them; all but ``renderer`` and ``snapshot`` needs the ``render`` extra."""
