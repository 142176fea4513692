"""A detection dataset: labeled objects among distractors before pictures or skies."""
