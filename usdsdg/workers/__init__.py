"""Several processes that make one dataset: which frames each makes, and what happens when one dies."""
