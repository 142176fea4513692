"""Forms in which many pictures are in one file, with their labels: WebDataset and Parquet."""
