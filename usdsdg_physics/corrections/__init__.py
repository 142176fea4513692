"""Corrections that the solver does not make: depenetration, tunneling guard, sleeping."""
