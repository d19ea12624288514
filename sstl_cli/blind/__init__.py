"""Withheld-effect check: cases from the rig under sealed truths, and how the diagnosis scores on them."""

# cases of a set where nobody says how many: of short recordings, and of whole ones
QUICK_CASES, FULL_CASES = 12, 150
