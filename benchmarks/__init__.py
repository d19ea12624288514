"""Comparisons with what a user would do instead, run by `make bench`."""
