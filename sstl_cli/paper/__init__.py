"""The paper's published tables as data, and the comparison with them."""
