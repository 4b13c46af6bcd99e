"""Data out: episodes as rows of CSV and Parquet files, and their transitions as Minari datasets."""
