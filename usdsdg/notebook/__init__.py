"""What notebooks show: previews, and what annotators, stages, graphs and datasets hold."""
