"""Semantic labels on prims, and predicates over them."""
