"""Many worlds at once: what each shows, what is refused, and what its arrays are."""
