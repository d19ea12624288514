"""Plain-Python models to compare with, written without the package."""

from __future__ import annotations

import pyarrow as pa

from sstl_cli.core.parquet import write_table
from sstl_cli.core.provenance import Provenance
from sstl_cli.core.tables import THETA

TABLE_II = (0.583, -1.444, 1.688, -1.043)


def play(tension_in, lines, start):
    """Return the output of a play between two lines, sample by sample."""
    gp, bp, gr, br = lines
    out, y = [], start
    for t in tension_in:
        low, high = gp * t + bp, gr * t + br
        y = min(max(y, low), high)
        out.append(y)
    return out


def presliding(tension_in, lines, shares, start):
    """Return the mean of plays of different width, each from the pull line of the first tension."""
    gp, bp, gr, br = lines
    outs = []
    for c in shares:
        own = (1 + c * (gp - 1), c * bp, 1 + c * (gr - 1), c * br)
        outs.append(play(tension_in, own, own[0] * start + own[1]))
    return [sum(v) / len(shares) for v in zip(*outs, strict=True)]


def paper_controller(reference, measured, lines, doubled=True, t_max=80.0):
    """Return commands and phases of Algorithm 1 with the resolutions 1 to 6 of PAPER.md, without options."""
    gp, bp, gr, br = lines
    gamma, beta = {1: gp, -1: gr}, {1: bp, -1: br}
    direction, backlash, held = 0, False, 0.0
    commands, phases, before = [], [], None
    for ref, t_in in zip(reference, measured, strict=True):
        zeta = 0 if before is None else int(ref > before) - int(ref < before)
        if zeta != 0 and zeta != direction:
            if direction != 0 and not backlash:
                held = gamma[direction] * t_in + beta[direction]
                backlash = True
            direction = zeta
        d = direction or 1
        if backlash:
            threshold = (held - beta[d]) / gamma[d]
            # within 0.1 mN of the threshold backlash is over, whatever the rounding
            if (d > 0 and t_in >= threshold - 1e-4) or (d < 0 and t_in <= threshold + 1e-4):
                backlash = False
        target = 2 * ref - held if backlash and doubled else ref
        commands.append(min(max((target - beta[d]) / gamma[d], 0.0), t_max))
        phases.append(("P" if d > 0 else "R") + ("B" if backlash else "P"))
        before = ref
    return commands, phases


def theta_row(run_id, config, system, lines, status="ok", location="CP"):
    """Return one row of a Theta table."""
    gp, bp, gr, br = lines
    return {
        "run_id": run_id,
        "config_id": config,
        "system": system,
        "location": location,
        "lead_mm": 40.0,
        "gamma_p": gp,
        "beta_p": bp,
        "gamma_r": gr,
        "beta_r": br,
        "loops": 1,
        "status": status,
    }


def write_theta(path, rows):
    """Write rows as a Theta table."""
    table = pa.Table.from_pylist(rows, schema=THETA.arrow())
    write_table(path, table, THETA, Provenance("test"), force=True)
    return path
