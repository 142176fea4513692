"""Where datasets are: folders and buckets, their locks, and the numbers of folders that writers get."""
