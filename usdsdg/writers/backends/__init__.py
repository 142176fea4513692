"""Where writers' bytes go: folders, buckets, and the I/O queue in front of them."""
