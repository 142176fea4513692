"""Correct contacts and bodies where the solver does not: depenetration, impacts, sleeping, stabilization."""
