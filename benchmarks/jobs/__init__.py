"""One benchmark a file: `run(quick, folder)` returns its rows."""
