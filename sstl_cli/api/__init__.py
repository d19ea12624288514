"""The public face for Python: typed objects on top of the steps that the commands run."""
