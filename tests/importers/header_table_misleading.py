"""Headers that were taken at their word and mean something else: names of what was never measured, odd clocks, signs.

``None`` as in ``header_table``: the file does not say it, so it must be asked.
"""

from __future__ import annotations

from header_table import LVM, Header, T, X, Y, rows
from header_table_more import ASK, KGF, R

NOT_MEASURED = (
    "T_out_d (N)", "T_out* (N)", "T_out_sim (N)", "T_out_hat (N)", "PID output (N)", "Controller output (N)", "Amplifier output (N)",
    "Requested output tension (N)", "Planned output tension (N)", "Theoretical output tension (N)", "T_out_calc (N)", "T_out_est (N)",
    "Output tension estimate (N)", "T_out observer (N)", "T_out ideal (N)", "Output limit (N)", "Output tension threshold (N)",
    "Output preload (N)", "Output tension offset (N)", "Output tension tare (N)", "Output tension noise (N)",
    "Output tension uncertainty (N)", "Output tension std (N)", "Output tension max (N)", "Output tension min (N)", "T_out_pred (N)",
    "T_out FEM (N)", "T_out theory (N)", "Expected output tension (N)", "Simulated tip force (N)", "Computed distal tension (N)",
    "Virtual output tension (N)", "T_out capstan (N)", "Output saturation (N)", "Tip stiffness (N)", "Distal normal force (N)",
    "Output tension log10 (N)", "T_out model (N)", "-T_out (N)", "Output tension ch2-ch1 (N)", "T_out x2 (N)", "T_out*10 (N)",
    "Tip contact force (N)", "Tip lateral force (N)",
)  # fmt: skip
UNMEASURED = tuple(
    Header(f"{name} alone", f"Time (s),Fin (N),{name}\n" + rows(T, X, Y), ("Time (s)", "s"), ("Fin (N)", "N"), ASK) for name in NOT_MEASURED
)
BESIDE = (
    Header(
        "a model beside the load cell of the same side",
        "Time (s),T_in (N),T_out_model (N),T_out (N)\n" + rows(T, X, R, Y),
        ("Time (s)", "s"),
        ("T_in (N)", "N"),
        ("T_out (N)", "N"),
    ),
    Header(
        "what is desired beside what was measured",
        "Time (s),T_in_d (N),T_in (N),Tip load cell (N)\n" + rows(T, R, X, Y),
        ("Time (s)", "s"),
        ("T_in (N)", "N"),
        ("Tip load cell (N)", "N"),
    ),
    Header(
        "mean, maximum and deviation",
        "Time (s),Fin mean (N),Fin max (N),Fin std (N),Fout mean (N),Fout max (N)\n" + rows(T, X, X + 1, 0.1 * R, Y, Y + 1),
        ("Time (s)", "s"),
        ("Fin mean (N)", "N"),
        ("Fout mean (N)", "N"),
    ),
)


def timed(name: str, clock: object, unit: str | None, digits: int = 8) -> Header:
    """Return a log whose clock has a name and values of its own; no unit: it must be asked."""
    said = (name, unit) if unit else ASK
    return Header(
        f"clock {name} {unit}", f"{name},Fin (N),Fout (N)\n" + rows(clock, X, Y, digits=digits), said, ("Fin (N)", "N"), ("Fout (N)", "N")
    )


CLOCKS = (
    *(timed(name, T / 60, "min") for name in ("Time (mins)", "Zeit (Min)", "Time [minutes]", "Zeit [Minuten]", "time_min")),
    timed("Time (S)", T, "s"),
    *(
        timed(name, T, None)
        for name in ("Time (cycles)", "Time normalized", "Time*10 (s)", "Time (m)", "Time (UTC)", "Time (ds)", "Cycle time (s)")
    ),
    # half a millisecond, tenths of a second in minutes, and 20 Hz in minutes
    timed("Time", 125 * T, None, 1),
    timed("Time", T / 0.004 / 600, None, 6),
    timed("Time", T / 0.004 / 1200, None, 4),
    timed("Time", T / 0.004 * 0.013, None),
    timed("Time", 140_321.0 + T, None, 3),
    *(timed("Time", T / 0.004 / rate, "s") for rate in (10, 50, 100, 250, 1000, 2000)),
)
ODD = (
    Header(
        "LabVIEW .lvm, two voltages by their unit alone",
        LVM.replace("Newtons", "Volts").replace("Force_in", "Voltage").replace("Force_out", "Voltage_0")
        + rows(T, X / 20, Y / 20, sep="\t"),
        ("X_Value", "s"),
        ASK,
        ASK,
    ),
    Header(
        "a clock named after the load cell of each side",
        "Time - Load Cell Motor,Load Cell Motor (kgf),Time - Load Cell Tip,Load Cell Tip (kgf)\n" + rows(T, X / KGF, T + 0.001, Y / KGF),
        # the output gets the clock in front of it, time = "Time - Load Cell Tip"
        ("Time - Load Cell Motor", "s"),
        ("Load Cell Motor (kgf)", "kgf"),
        ("Load Cell Tip (kgf)", "kgf"),
    ),
    Header("a unit that is doubted", "Time (s),Fin [N?],Fout [N]\n" + rows(T, X, Y), ("Time (s)", "s"), ASK, ("Fout [N]", "N")),
    Header(
        "minutes in a row of units",
        "Zeit;Kraft Eingang;Kraft Ausgang\nMin;N;N\n" + rows(T / 60, X, Y, sep=";", dec=",", digits=8),
        ("Zeit", "min"),
        ("Kraft Eingang", "N"),
        ("Kraft Ausgang", "N"),
    ),
    Header("a clock of the force", "Fin.time,Fin,Fout\n" + rows(T, X, Y), ("Fin.time", "s"), ("Fin", None), ("Fout", None)),
    *(
        Header(
            f"units spelt {unit}",
            f"Time (s),Fin [{unit}],Fout [{unit}]\n" + rows(T, X, Y),
            ("Time (s)", "s"),
            (f"Fin [{unit}]", known),
            (f"Fout [{unit}]", known),
        )
        for unit, known in (("Kgf", "kgf"), ("KG", "kgf"), ("Oz", "ozf"), ("Pounds", "lbf"), ("KN", "kN"))
    ),
    *(
        Header(f"a header in {encoding}", f"{a},{b},{c}\n" + rows(1000 * T, X, Y), (a, "ms"), (b, "gf"), (c, "gf"), encoding)
        for encoding, a, b, c in (
            ("cp932", "時刻[ms]", "入力張力[gf]", "出力張力[gf]"),
            ("big5", "時間[ms]", "輸入張力[gf]", "輸出張力[gf]"),
            ("euc_kr", "시간[ms]", "입력 장력[gf]", "출력 장력[gf]"),
            ("gb2312", "时间[ms]", "输入拉力[gf]", "输出拉力[gf]"),
        )
    ),
)
MISLEADING = (*UNMEASURED, *BESIDE, *CLOCKS, *ODD)
