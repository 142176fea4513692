"""Guards against what contacts that were just found do wrong: they turn them, before these are corrected and solved."""
