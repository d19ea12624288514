"""25 headers as loggers write them, and what a person who knows the rig would answer.

Written after the guess was frozen. ``None`` as the unit or channel means: the file does not say it, so it must be asked.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

# more than a turn of the loop and more than a second: what is told of a table is told by its first rows
N = 260
T = np.arange(N) * 0.004


def _loop() -> tuple[np.ndarray, np.ndarray]:
    x = 10.0 - 8.0 * np.cos(2 * np.pi * T / 0.8)
    out = np.empty(N)
    now = 0.0
    for i, v in enumerate(x):
        now = min(max(now, 0.55 * v), 0.85 * v)
        out[i] = now
    rng = np.random.default_rng(11)
    return x + rng.normal(0, 0.02, N), out + rng.normal(0, 0.02, N)


X, Y = _loop()
Said = tuple[str | None, str | None]


@dataclass(frozen=True)
class Header:
    """A file as its logger writes it, with the true channel and unit of clock, input and output."""

    logger: str
    text: str
    time: Said
    first: Said
    second: Said
    encoding: str = "utf-8"


def rows(*columns: object, sep: str = ",", dec: str = ".", digits: int = 5) -> str:
    """Return the lines of a table; numbers with ``digits`` places, texts as they are."""

    def cell(column: object, i: int) -> str:
        if isinstance(column, str):
            return column
        if callable(column):
            return str(column(i))
        value = column[i]  # type: ignore[index]
        text = str(int(value)) if float(value).is_integer() and digits == 0 else f"{value:.{digits}f}"
        return text.replace(".", dec)

    return "".join(sep.join(cell(c, i) for c in columns) + "\n" for i in range(N))


def clock(i: int) -> str:
    """Return a time of day as spreadsheets write it."""
    return f"10:15:{int(T[i]):02d}.{int(1000 * T[i]) % 1000:03d}"


COUNT = np.arange(N)
ADC_X, ADC_Y = np.round(512 + 20 * X), np.round(498 + 20 * Y)
HX_X, HX_Y = np.round(84_000 + 21_000 * X), np.round(-52_000 + 21_000 * Y)
EPOCH = 1_718_000_000.0
secs: Callable[[int], str] = lambda i: str(int(EPOCH + T[i]))  # noqa: E731
nsecs: Callable[[int], str] = lambda i: str(round(1e9 * (T[i] % 1)))  # noqa: E731
LVM = (
    "LabVIEW Measurement\t\nWriter_Version\t2\nReader_Version\t2\nSeparator\tTab\nDecimal_Separator\t.\n"
    "Multi_Headings\tNo\nX_Columns\tOne\nTime_Pref\tRelative\nOperator\tlab\nDate\t2024/03/05\n"
    "Time\t10:15:00.1234567\n***End_of_Header***\t\n\t\nChannels\t2\t\t\nSamples\t400\t400\t\n"
    "Date\t2024/03/05\t2024/03/05\t\nY_Unit_Label\tNewtons\tNewtons\t\nX_Dimension\tTime\tTime\t\nDelta_X\t0.004\t0.004\t\n"
    "***End_of_Header***\t\t\t\nX_Value\tForce_in\tForce_out\tComment\n"
)

HEADERS = (
    Header("LabVIEW .lvm", LVM + rows(T, X, Y, sep="\t"), ("X_Value", "s"), ("Force_in", "N"), ("Force_out", "N")),
    Header("LabVIEW Write To Spreadsheet File", rows(T, X, Y, sep="\t"), (None, None), (None, None), (None, None)),
    Header(
        "LabVIEW, volts of two load cells",
        "Time (s)\tLoad Cell Motor (V)\tLoad Cell Distal (V)\n" + rows(T, X / 10, Y / 10, sep="\t"),
        ("Time (s)", "s"),
        ("Load Cell Motor (V)", None),
        ("Load Cell Distal (V)", None),
    ),
    Header(
        "Simulink To Workspace, writematrix", "time,F_in,F_out\n" + rows(T, X, Y, digits=12), ("time", "s"), ("F_in", None), ("F_out", None)
    ),
    Header(
        "Simulink log with a commanded stroke",
        "Time,Stroke_Ref,Tension\n" + rows(T, 0.4 * X, Y),
        ("Time", "s"),
        (None, None),
        ("Tension", None),
    ),
    Header(
        "MATLAB writetimetable",
        "Time,TensionIn_N,TensionOut_N\n" + rows(lambda i: f"{T[i]:.3f} sec", X, Y),
        ("Time", "s"),
        ("TensionIn_N", "N"),
        ("TensionOut_N", "N"),
    ),
    Header(
        "dSPACE ControlDesk CSV export",
        'CSV export;ControlDesk 7.4\nrecorder;"Recorder_1"\ndescription;\n'
        "Time;Platform()://Plant/Motor Tension [N]/Out1;Platform()://Plant/Tip Tension [N]/Out1\n" + rows(T, X, Y, sep=";"),
        ("Time", "s"),
        ("Platform()://Plant/Motor Tension [N]/Out1", "N"),
        ("Platform()://Plant/Tip Tension [N]/Out1", "N"),
    ),
    Header(
        "ROS 1 rostopic echo -p of a wrench",
        "%time,field.header.seq,field.header.stamp,field.header.frame_id,field.wrench.force.x,field.wrench.force.y,"
        "field.wrench.force.z,field.wrench.torque.x,field.wrench.torque.y,field.wrench.torque.z\n"
        + rows(
            lambda i: str(round((EPOCH + T[i]) * 1e9)),
            lambda i: str(i),
            lambda i: str(round((EPOCH + T[i]) * 1e9)),
            "ft_sensor",
            0.01 * Y,
            -0.02 * X,
            Y,
            0.001 * X,
            0.001 * Y,
            0.0001 * X,
        ),
        ("field.header.stamp", "ns"),
        (None, None),
        (None, None),
    ),
    Header(
        "ROS 2, PlotJuggler CSV",
        "__time,/motor/tension/data,/tip/tension/data\n" + rows(EPOCH + T, X, Y),
        ("__time", "s"),
        ("/motor/tension/data", None),
        ("/tip/tension/data", None),
    ),
    Header(
        "ROS 1 bag to CSV with seconds and nanoseconds apart",
        "header.seq,header.stamp.secs,header.stamp.nsecs,tension_prox,tension_dist\n" + rows(lambda i: str(i), secs, nsecs, X, Y),
        ("header.stamp.secs", "s"),
        ("tension_prox", None),
        ("tension_dist", None),
    ),
    Header(
        "Arduino, ten-bit readings",
        "millis,in,out\n" + rows(1000 * T, ADC_X, ADC_Y, digits=0),
        ("millis", "ms"),
        ("in", None),
        ("out", None),
    ),
    Header(
        "Arduino, two HX711",
        "time_us;loadcell_1;loadcell_2\n" + rows(1e6 * T, HX_X, HX_Y, sep=";", digits=0),
        ("time_us", "us"),
        (None, None),
        (None, None),
    ),
    Header(
        "Arduino through PLX-DAQ",
        "Date,Time,Started Time,Force motor N,Force tip N\n" + rows("05/03/2024", clock, lambda i: f"{T[i]:.3f}", X, Y),
        ("Started Time", "s"),
        ("Force motor N", "N"),
        ("Force tip N", "N"),
    ),
    Header(
        "Excel, German",
        "Zeit in s;Eingangskraft in N;Ausgangskraft in N;Weg in mm\n" + rows(T, X, Y, 0.3 * X, sep=";", dec=","),
        ("Zeit in s", "s"),
        ("Eingangskraft in N", "N"),
        ("Ausgangskraft in N", "N"),
    ),
    Header(
        "Excel, French",
        "Temps (s);Tension amont (N);Tension aval (N)\n" + rows(T, X, Y, sep=";", dec=","),
        ("Temps (s)", "s"),
        ("Tension amont (N)", "N"),
        ("Tension aval (N)", "N"),
        "latin-1",
    ),
    Header(
        "Excel, Spanish",
        "Tiempo (ms);Tensión del cable, motor (N);Tensión del cable, distal (N)\n" + rows(1000 * T, X, Y, sep=";", dec=",", digits=3),
        ("Tiempo (ms)", "ms"),
        ("Tensión del cable, motor (N)", "N"),
        ("Tensión del cable, distal (N)", "N"),
        "latin-1",
    ),
    Header(
        "HBM catman",
        "Zeit  1 - Standardmessrate\tKraft_prox\tKraft_dist\ns\tN\tN\n" + rows(T, X, Y, sep="\t"),
        ("Zeit  1 - Standardmessrate", "s"),
        ("Kraft_prox", "N"),
        ("Kraft_dist", "N"),
    ),
    Header(
        "FUTEK SENSIT",
        "Sample Number,Time(ms),Channel1 (lbf),Channel2 (lbf)\n" + rows(COUNT, 1000 * T, X / 4.448, Y / 4.448, digits=4),
        ("Time(ms)", "ms"),
        (None, None),
        (None, None),
    ),
    Header(
        "pandas to_csv with its index", ",t,fin_N,fout_N\n" + rows(lambda i: str(i), T, X, Y), ("t", "s"), ("fin_N", "N"), ("fout_N", "N")
    ),
    Header(
        "Instron tensile tester",
        '"Time","Extension","Load"\n"(s)","(mm)","(N)"\n' + rows(T, 0.3 * X, Y),
        ("Time", "s"),
        (None, None),
        (None, None),
    ),
    Header(
        "Beckhoff TwinCAT Scope, a clock for each channel",
        "Time;MAIN.fForceIn;Time;MAIN.fForceOut\n" + rows(1000 * T, X, 1000 * T, Y, sep=";", digits=3),
        (None, None),
        ("MAIN.fForceIn", None),
        ("MAIN.fForceOut", None),
    ),
    Header(
        "Tektronix oscilloscope",
        "Model,MSO44\nSample Interval,4.0E-3\nVertical Units,V,V\n\nTIME,CH1,CH2\n" + rows(T, X / 10, Y / 10),
        ("TIME", "s"),
        (None, None),
        (None, None),
    ),
    Header(
        "PLC, percent of range with a set point",
        "Zeit [s];F_ist [%];F_soll [%]\n" + rows(T, 5 * X, 5 * X, sep=";"),
        ("Zeit [s]", "s"),
        (None, None),
        (None, None),
    ),
    Header(
        "DAQ with a sample number only",
        "Sample,Fin [N],Fout [N]\n" + rows(lambda i: str(i), X, Y),
        (None, None),
        ("Fin [N]", "N"),
        ("Fout [N]", "N"),
    ),
    Header(
        "Python logger, unix milliseconds",
        "timestamp,actuator_tension_N,sheath_end_tension_N\n" + rows(1000 * (EPOCH + T), X, Y, digits=3),
        ("timestamp", "ms"),
        ("actuator_tension_N", "N"),
        ("sheath_end_tension_N", "N"),
    ),
)
