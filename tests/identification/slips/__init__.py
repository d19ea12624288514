"""Sound recordings drawn at random, and slips that spoil them one at a time."""
