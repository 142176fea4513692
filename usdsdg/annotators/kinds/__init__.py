"""The annotators, one module for each group of related outputs."""
