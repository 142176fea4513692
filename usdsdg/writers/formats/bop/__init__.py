"""The BOP form: scenes with poses in millimeters, masks, and models."""
