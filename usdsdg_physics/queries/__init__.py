"""Answer scene queries: overlaps and ray casts."""
