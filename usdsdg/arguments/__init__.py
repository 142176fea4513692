"""What users pass to the families: values, prims, names of members; each error says what was expected."""
