"""Correct contacts and bodies where the solver does not: tunneling guard, depenetration, sleeping, stabilization."""
