"""Conversion and validation of the arguments that users pass: values, prims, names of registered members."""
