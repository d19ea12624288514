"""One module per log format (discovered), and what all of them share: mapping, clocks, repair."""
