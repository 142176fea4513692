"""Sampling and evaluating lights."""
