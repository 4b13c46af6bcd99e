"""A folder of published entries, its index and the pages made of it."""
