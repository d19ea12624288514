"""Withheld-effect check: cases from the rig under sealed truths, and how the diagnosis scores on them."""
