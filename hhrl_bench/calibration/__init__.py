"""Calibration to the paper: the world in which Rules 1 to 4 come to its Table I, and the constants of its reward."""
