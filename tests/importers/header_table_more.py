"""More headers as LabVIEW, Simulink, dSPACE, ROS, Arduino and spreadsheets in three languages write them.

Written after the proposals on those of ``header_table`` were mended. ``None`` as in there: the file does not say it.
"""

from __future__ import annotations

import numpy as np
from header_table import ADC_X, ADC_Y, COUNT, EPOCH, HX_X, HX_Y, Header, T, X, Y, clock, rows

R = 10.0 - 8.0 * np.cos(2 * np.pi * T / 0.8)
LBF, KGF, DAN = 4.4482216, 9.80665, 10.0
Said = tuple[str | None, str | None]
ASK: Said = (None, None)
LVM = (
    "LabVIEW Measurement\t\nWriter_Version\t2\nReader_Version\t2\nSeparator\tTab\nDecimal_Separator\t,\nMulti_Headings\tYes\n"
    "X_Columns\tMulti\nTime_Pref\tAbsolute\n***End_of_Header***\t\n\t\nChannels\t2\t\t\t\nSamples\t400\t\t400\t\n"
    "Y_Unit_Label\tVolts\t\tVolts\t\nX_Dimension\tTime\t\tTime\t\nX0\t0,0\t\t0,0\t\nDelta_X\t0,004\t\t0,004\t\n"
    "***End_of_Header***\t\t\t\t\nX_Value\tVoltage\tX_Value\tVoltage_0\tComment\n"
)
NS = [str(round((EPOCH + t) * 1e9)) for t in T]
EXCEL_DAY = 45_356.0


def ns(i: int) -> str:
    """Return a stamp in nanoseconds, which no float holds."""
    return NS[i]


def day_and_time(i: int) -> str:
    """Return a date with a time of day as German spreadsheets write it."""
    return f"05.03.2024 {clock(i).replace('.', ',')}"


LABVIEW = (
    Header(
        "LabVIEW .lvm, a clock for each of two voltages", LVM + rows(T, X / 10, T, Y / 10, sep="\t", dec=","), ("X_Value.1", "s"), ASK, ASK
    ),
    Header(
        "LabVIEW, physical channels of a card",
        "Time\tcDAQ1Mod1/ai0\tcDAQ1Mod1/ai1\n" + rows(T, X / 10, Y / 10, sep="\t"),
        ("Time", "s"),
        ASK,
        ASK,
    ),
    Header(
        "LabVIEW in German, bridges in mV/V",
        "Zeit [s]\tDMS Eingang [mV/V]\tDMS Ausgang [mV/V]\n" + rows(T, X / 30, Y / 30, sep="\t", dec=","),
        ("Zeit [s]", "s"),
        ("DMS Eingang [mV/V]", None),
        ("DMS Ausgang [mV/V]", None),
    ),
    Header(
        "FlexLogger with a thermocouple",
        "Time (s),Tension Proximal (N),Tension Distal (N),Thermocouple 1 (°C)\n" + rows(T, X, Y, 20 + 0.01 * X),
        ("Time (s)", "s"),
        ("Tension Proximal (N)", "N"),
        ("Tension Distal (N)", "N"),
    ),
    Header(
        "DIAdem, the output in the first column",
        "Zeit_s;Seilkraft_Abtrieb_N;Seilkraft_Antrieb_N;Weg_mm\n" + rows(T, Y, X, 0.3 * X, sep=";", dec=","),
        ("Zeit_s", "s"),
        ("Seilkraft_Antrieb_N", "N"),
        ("Seilkraft_Abtrieb_N", "N"),
    ),
)
SIMULINK = (
    Header("Simulink, tout and yout", "tout,yout1,yout2\n" + rows(T, X, Y, digits=8), ("tout", "s"), ASK, ASK),
    Header("Simulink scope, u and y", "time,u,y\n" + rows(T, X, Y, digits=8), ("time", "s"), ASK, ASK),
    Header(
        "Simulink Data Inspector, a row of units",
        "time,Plant/Cable/F_prox,Plant/Cable/F_dist\ns,N,N\n" + rows(T, X, Y, digits=9),
        ("time", "s"),
        ("Plant/Cable/F_prox", "N"),
        ("Plant/Cable/F_dist", "N"),
    ),
    Header("MATLAB writetable without names", "Var1,Var2,Var3\n" + rows(T, X, Y), ASK, ASK, ASK),
    Header(
        "MATLAB table with a command of the force",
        "Time_s,ForceCmd_N,ForceMotor_N,ForceTip_N\n" + rows(T, R, X, Y),
        ("Time_s", "s"),
        ("ForceMotor_N", "N"),
        ("ForceTip_N", "N"),
    ),
)
DSPACE = (
    Header(
        "dSPACE, quoted block paths",
        '"Time [s]","Model Root/Sensors/Motor Force [N]/Value","Model Root/Sensors/Distal Force [N]/Value"\n' + rows(T, X, Y),
        ("Time [s]", "s"),
        ("Model Root/Sensors/Motor Force [N]/Value", "N"),
        ("Model Root/Sensors/Distal Force [N]/Value", "N"),
    ),
    Header(
        "dSPACE, kN",
        "Zeit;F_Eingang [kN];F_Ausgang [kN]\n" + rows(T, X / 1e3, Y / 1e3, sep=";", dec=",", digits=7),
        ("Zeit", "s"),
        ("F_Eingang [kN]", "kN"),
        ("F_Ausgang [kN]", "kN"),
    ),
    Header(
        "dSPACE, inputs of the converter",
        "Time,DS1104ADC_C5/ADC,DS1104ADC_C6/ADC\n" + rows(T, X / 200, Y / 200, digits=7),
        ("Time", "s"),
        ASK,
        ASK,
    ),
    Header(
        "dSPACE, demanded and actual force and the tip",
        "Time,Model Root/Force_Ref [N],Model Root/Force_Act [N],Model Root/Force_Tip [N]\n" + rows(T, R, X, Y),
        ("Time", "s"),
        ("Model Root/Force_Act [N]", "N"),
        ("Model Root/Force_Tip [N]", "N"),
    ),
)
ROS = (
    Header(
        "ROS 2 bag as CSV, two wrenches",
        "timestamp_ns,/tendon_in/wrench/force/z,/tendon_out/wrench/force/z\n" + rows(ns, X, Y),
        ("timestamp_ns", "ns"),
        ("/tendon_in/wrench/force/z", None),
        ("/tendon_out/wrench/force/z", None),
    ),
    Header(
        "ROS 2 joint states",
        "header.stamp.sec,header.stamp.nanosec,position[0],position[1],effort[0],effort[1]\n"
        + rows(lambda i: str(int(EPOCH + T[i])), lambda i: str(round(1e9 * (T[i] % 1))), 0.1 * X, 0.1 * Y, X, Y),
        ("header.stamp.sec", "s"),
        ASK,
        ASK,
    ),
    Header(
        "rqt_bag, load cells of motor and end effector",
        "time,/load_cell/motor/data,/load_cell/end_effector/data\n" + rows(EPOCH + T, X, Y),
        ("time", "s"),
        ("/load_cell/motor/data", None),
        ("/load_cell/end_effector/data", None),
    ),
    Header(
        "ros2 topic echo --csv, no header",
        rows(lambda i: str(int(EPOCH + T[i])), lambda i: str(round(1e9 * (T[i] % 1))), "cell", X, Y),
        ASK,
        ASK,
        ASK,
    ),
)
ARDUINO = (
    Header(
        "Arduino, grams",
        "time_ms,T_motor_g,T_tip_g\n" + rows(1000 * T, 1000 * X / KGF, 1000 * Y / KGF, digits=1),
        ("time_ms", "ms"),
        ("T_motor_g", "gf"),
        ("T_tip_g", "gf"),
    ),
    Header(
        "Arduino, kg behind the name",
        "micros,forceIn(kg),forceOut(kg)\n" + rows(1e6 * T, X / KGF, Y / KGF, digits=5),
        ("micros", "us"),
        ("forceIn(kg)", "kgf"),
        ("forceOut(kg)", "kgf"),
    ),
    Header("Arduino, one letter and a number", "t;F1;F2;pwm\n" + rows(1000 * T, X, Y, ADC_X, sep=";", digits=0), ASK, ASK, ASK),
    Header("Arduino, raw readings", "ms raw_a raw_b\n" + rows(1000 * T, HX_X, HX_Y, sep=" ", digits=0), ("ms", "ms"), ASK, ASK),
    Header(
        "Arduino, a count as time",
        "time,inputForce_N,outputForce_N\n" + rows(COUNT, X, Y, digits=3).replace(".000,", ",", 0),
        ASK,
        ("inputForce_N", "N"),
        ("outputForce_N", "N"),
    ),
)
GERMAN = (
    Header(
        "Excel, German, date and time of day",
        "Zeitpunkt;Seilkraft proximal [N];Seilkraft distal [N]\n" + rows(day_and_time, X, Y, sep=";", dec=","),
        ("Zeitpunkt", "s"),
        ("Seilkraft proximal [N]", "N"),
        ("Seilkraft distal [N]", "N"),
        "latin-1",
    ),
    Header(
        "Excel, German, kiloponds and a running number",
        "lfd. Nr.;Zeit [ms];Zugkraft Motor [kp];Zugkraft Endeffektor [kp]\n"
        + rows(lambda i: str(i + 1), 1000 * T, X / KGF, Y / KGF, sep=";", dec=","),
        ("Zeit [ms]", "ms"),
        ("Zugkraft Motor [kp]", "kgf"),
        ("Zugkraft Endeffektor [kp]", "kgf"),
    ),
    Header(
        "Excel, German, decanewtons",
        "Messzeit (sek);F_ein (daN);F_aus (daN)\n" + rows(T, X / DAN, Y / DAN, sep=";", dec=","),
        ("Messzeit (sek)", "s"),
        ("F_ein (daN)", "daN"),
        ("F_aus (daN)", "daN"),
    ),
    Header(
        "Excel, German, set point and reading",
        "Zeit in s;Sollkraft in N;Istkraft in N;Kraft am Abtrieb in N\n" + rows(T, R, X, Y, sep=";", dec=","),
        ("Zeit in s", "s"),
        ("Istkraft in N", "N"),
        ("Kraft am Abtrieb in N", "N"),
    ),
    Header(
        "Excel, German, minutes",
        "Zeit (min);Vorspannung Motorseite (N);Spannung Lastseite (N)\n" + rows(T / 60, X, Y, sep=";", dec=",", digits=7),
        ("Zeit (min)", "min"),
        ("Vorspannung Motorseite (N)", "N"),
        ("Spannung Lastseite (N)", "N"),
    ),
)
FRENCH = (
    Header(
        "Excel, French, decanewtons",
        "Temps [s];Force d'entrée [daN];Force de sortie [daN]\n" + rows(T, X / DAN, Y / DAN, sep=";", dec=","),
        ("Temps [s]", "s"),
        ("Force d'entrée [daN]", "daN"),
        ("Force de sortie [daN]", "daN"),
        "latin-1",
    ),
    Header(
        "Excel, French, effort",
        "N° échantillon;Horodatage (ms);Effort moteur (N);Effort extrémité (N)\n"
        + rows(lambda i: str(i), 1000 * T, X, Y, sep=";", dec=","),
        ("Horodatage (ms)", "ms"),
        ("Effort moteur (N)", "N"),
        ("Effort extrémité (N)", "N"),
        "latin-1",
    ),
    Header(
        "Excel, French, voltages, which are called tension too",
        "Durée (s);Tension capteur entrée (mV);Tension capteur sortie (mV)\n" + rows(T, 10 * X, 10 * Y, sep=";", dec=","),
        ("Durée (s)", "s"),
        ("Tension capteur entrée (mV)", None),
        ("Tension capteur sortie (mV)", None),
        "latin-1",
    ),
    Header(
        "Excel, French, a set point",
        "temps_s;consigne_N;traction_entree_N;traction_sortie_N\n" + rows(T, R, X, Y, sep=";", dec=","),
        ("temps_s", "s"),
        ("traction_entree_N", "N"),
        ("traction_sortie_N", "N"),
    ),
)
SPANISH = (
    Header(
        "Excel, Spanish, kgf",
        "Tiempo [s];Fuerza proximal [kgf];Fuerza distal [kgf]\n" + rows(T, X / KGF, Y / KGF, sep=";", dec=","),
        ("Tiempo [s]", "s"),
        ("Fuerza proximal [kgf]", "kgf"),
        ("Fuerza distal [kgf]", "kgf"),
    ),
    Header(
        "Excel, Spanish, units close behind the name",
        "t(s);F entrada(N);F salida(N);Desplazamiento(mm)\n" + rows(T, X, Y, 0.3 * X, sep=";", dec=","),
        ("t(s)", "s"),
        ("F entrada(N)", "N"),
        ("F salida(N)", "N"),
    ),
    Header(
        "Excel, Spanish, a sample number",
        "Muestra;Fuerza motor;Fuerza punta\n" + rows(lambda i: str(i), X, Y, sep=";", dec=","),
        ASK,
        ("Fuerza motor", None),
        ("Fuerza punta", None),
    ),
    Header(
        "Excel, Spanish, pounds and a time of day",
        "Hora;Carga motor (lb);Carga extremo (lb)\n" + rows(clock, X / LBF, Y / LBF, sep=";", dec=","),
        ("Hora", "s"),
        ("Carga motor (lb)", "lbf"),
        ("Carga extremo (lb)", "lbf"),
    ),
    Header(
        "Excel, Spanish, days since 1900",
        "Fecha;Tracción del actuador (N);Tracción de la punta (N)\n" + rows(EXCEL_DAY + T / 86400, X, Y, sep=";", dec=",", digits=10),
        ("Fecha", "h"),
        ("Tracción del actuador (N)", "N"),
        ("Tracción de la punta (N)", "N"),
        "latin-1",
    ),
)
ODD = (
    Header(
        "motor side and load side",
        "Time (s),Load-side tension (N),Motor-side tension (N)\n" + rows(T, Y, X),
        ("Time (s)", "s"),
        ("Motor-side tension (N)", "N"),
        ("Load-side tension (N)", "N"),
    ),
    Header(
        "torques of both ends", "Time (s),Input torque (Nm),Output torque (Nm)\n" + rows(T, X / 10, Y / 10), ("Time (s)", "s"), ASK, ASK
    ),
    Header(
        "a clock that says s and counts ms",
        "Time (s),Force in (N),Force out (N)\n" + rows(1000 * T, X, Y, digits=0).replace(".0", ""),
        ASK,
        ("Force in (N)", "N"),
        ("Force out (N)", "N"),
    ),
    Header("tens of newtons", "Time (s),Fin (x10 N),Fout (x10 N)\n" + rows(T, X / 10, Y / 10), ("Time (s)", "s"), ASK, ASK),
    Header("tenths of a newton", "Time (s),Fin [0.1 N],Fout [N*0.1]\n" + rows(T, 10 * X, 10 * Y, digits=3), ("Time (s)", "s"), ASK, ASK),
    Header(
        "a clock of ten microseconds",
        "Time (10 us),Fin (N),Fout (N)\n" + rows(1e5 * T, X, Y, digits=1),
        ASK,
        ("Fin (N)", "N"),
        ("Fout (N)", "N"),
    ),
    Header(
        "what is lost on the way",
        "Time (s),Motor tension (N),Output tension loss (N)\n" + rows(T, X, X - Y),
        ("Time (s)", "s"),
        ("Motor tension (N)", "N"),
        ASK,
    ),
    Header("a difference", "Time (s),Fin (N),Delta F out (N)\n" + rows(T, X, X - Y), ("Time (s)", "s"), ("Fin (N)", "N"), ASK),
    Header(
        "temperatures named like tensions",
        "Time (s),T_in (°C),T_out (°C),F1 (N),F2 (N)\n" + rows(T, 20 + X, 20 + Y, X, Y),
        ("Time (s)", "s"),
        ASK,
        ASK,
    ),
    Header(
        "force in N and force out",
        "Time in s,Force in N,Force out N\n" + rows(T, X, Y),
        ("Time in s", "s"),
        ("Force in N", "N"),
        ("Force out N", "N"),
    ),
    Header("one force in N", "Time in s,Stroke in mm,Force in N\n" + rows(T, X, Y), ("Time in s", "s"), ASK, ASK),
    Header("ten-bit readings named as newtons", "t_s,Fin_N,Fout_N\n" + rows(T, 40 * ADC_X, 40 * ADC_Y, digits=3), ("t_s", "s"), ASK, ASK),
)
MORE = (*LABVIEW, *SIMULINK, *DSPACE, *ROS, *ARDUINO, *GERMAN, *FRENCH, *SPANISH, *ODD)
