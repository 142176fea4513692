"""Storage of files: folders, S3 buckets, groups of them, and the I/O queue in front."""
