"""Reports people look at: one self-contained page, one file a section, one file a figure."""
