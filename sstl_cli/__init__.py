"""Identify, compensate and diagnose tendon-sheath hysteresis from recorded tension logs."""

__version__ = "0.1.0"
