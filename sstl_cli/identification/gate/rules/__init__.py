"""The rules of the gate, one a file; a new file beside these is found by itself."""
