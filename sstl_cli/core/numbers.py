"""Numbers as a person reads them."""

from __future__ import annotations

LEAST = 1e-3


def small(value: float | None) -> float | str | None:
    """Return a number to be shown; one that differs from zero by less than a thousandth says just that.

    Examples
    --------
    >>> small(3e-13), small(0.25), small(None)
    ('< 0.001', 0.25, None)
    """
    return f"< {LEAST:g}" if value is not None and 0 < abs(value) < LEAST else value


def quantity(value: float | str | None, unit: str) -> str:
    """Return a number to two digits with its unit; what is dimensionless has none, what is not known is a dash.

    Examples
    --------
    >>> quantity(0.1234, "N"), quantity(0.1234, "1"), quantity(small(1e-9), "N"), quantity(None, "N")
    ('0.12 N', '0.12', '< 0.001 N', '-')
    """
    if value is None or value != value:
        return "-"
    shown = value if isinstance(value, str) else f"{value:.2g}"
    return shown if unit == "1" else f"{shown} {unit}"
