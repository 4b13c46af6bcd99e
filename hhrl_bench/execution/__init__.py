"""Who does the units of a study and how: in this process, in processes of this machine or on a Ray cluster."""
