"""What both spellings of domain randomization share: registered views, frames of environments, and what is written."""
