"""Repair of a dataset: which frames have its damaged files, and files that take their place once they are equal.

`damage` says what is damaged, and why nothing can be done about it where that is so, `plan` of what each damaged file
is made again, `spooled` makes those about all frames of their records, `replaced` puts files in the place of damaged
ones.
"""
