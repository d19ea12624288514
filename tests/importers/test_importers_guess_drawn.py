"""Twelve headers as programs of test rigs write them, drawn before looking at what becomes of them: what is not asked arrives as it was."""

from __future__ import annotations

import tomllib
from datetime import datetime, timedelta
from pathlib import Path

import numpy as np
import pytest
from header_table import X, Y

from sstl_cli.importers.guess import guess
from sstl_cli.importers.mapping import mapping_of
from sstl_cli.steps.import_ import run

S = np.arange(len(X)) * 0.01
BEGIN = datetime(2024, 5, 13, 14, 5, 6)
SIDES = {"tension_in_n", "tension_out_n"}


def lines(*columns: list[str], by: str = ",") -> str:
    return "".join(by.join(row) + "\n" for row in zip(*columns, strict=True))


def plain(values: np.ndarray, digits: int = 4) -> list[str]:
    return [f"{v:.{digits}f}" for v in values]


def comma(values: np.ndarray, digits: int = 4) -> list[str]:
    return [c.replace(".", ",") for c in plain(values, digits)]


def stamps(form: str) -> list[str]:
    return [(BEGIN + timedelta(seconds=float(t))).strftime(form)[:-3] for t in S]


COUNT = [str(i) for i in range(len(X))]
POUND = 9.80665 * 0.45359237
# text, and what is asked beside the system
HEADERS = {
    "dSPACE": ('"ControlDesk"\nsampling period,0.01\ntrace_name,"Model Root/F_in [N]","Model Root/F_out [N]"\nunit,N,N\ntrace_values\n' + lines(plain(S), plain(X), plain(Y)), set()),
    "Excel, German": ("Prüfstand;;;\nBiegung:;90°;;\n;;;\nZeit;Kraft Eingang;Kraft Ausgang\n[s];[N];[N]\n" + lines(comma(S, 2), comma(X), comma(Y), by=";"), {"config_id"}),
    "Excel, French": ("Essai n° 12;;\nCourbure : 30 deg;;\nTemps (s);Effort entrée (N);Effort sortie (N)\n" + lines(comma(S, 2), comma(X), comma(Y), by=";"), {"config_id"}),
    "Excel, US": ("Timestamp,Motor Force (lbf),Tip Force (lbf)\n" + lines(stamps("%d-%b-%Y %H:%M:%S.%f"), plain(X / POUND, 6), plain(Y / POUND, 6)), set()),
    "MTS": ("MTS793|MPT|ENU|1|2|.|/|:|1|0|0|A\n\nStation Name: rig\n\nTime\tInput Force\tOutput Force\nSec\tN\tN\n" + lines(plain(S), plain(X), plain(Y), by="\t"), set()),
    "Instron": ('"Specimen label","act 45deg"\n\n"Time","Load","Load 2"\n"(s)","(N)","(N)"\n' + lines(*([f'"{c}"' for c in v] for v in (plain(S), plain(X), plain(Y)))), {*SIDES, "config_id"}),
    "catman": ("catman AP\nZeit  1 - Standardrate\tKraft_motor\tKraft_spitze\ns\tN\tN\nSampleRate=100\t\t\n" + lines(comma(S), comma(X), comma(Y), by="\t"), set()),
    "DAQami": ('DAQami v4.2.1\n"Sample Rate (Hz):","100"\n\nSample,Date/Time,AI0 Fin (N),AI1 Fout (N)\n' + lines(COUNT, stamps("%m/%d/%Y %H:%M:%S.%f"), plain(X), plain(Y)), set()),
    "Logger Pro": ("Latest: Time (s)\tLatest: Force In (N)\tLatest: Force Out (N)\n" + lines(plain(S, 2), plain(X), plain(Y), by="\t"), set()),
    "Kistler": ("Kistler BioWare\nSampling rate [Hz]:;100\nRange:;500 N\nTime;Fz1 in;Fz2 out\ns;N;N\n" + lines(plain(S), plain(X), plain(Y), by=";"), set()),
    "MDF": ("timestamps,F_in_Sensor,F_out_Sensor\ns,daN,daN\n" + lines(plain(S), plain(X / 10, 6), plain(Y / 10, 6)), set()),
    "Dewesoft": ("Dewesoft text export\nSample rate: 100 Hz\nStart time: 13.05.2024 14:05:06\n\nTime (s)\tT_in/AVE (N)\tT_out/AVE (N)\n" + lines(plain(S), plain(X), plain(Y), by="\t"), set()),
}  # fmt: skip


@pytest.mark.parametrize("name", HEADERS)
def test_what_is_not_asked_of_a_drawn_header_arrives_as_it_was(name: str, tmp_path: Path) -> None:
    text, asked = HEADERS[name]
    path = tmp_path / "log.csv"
    path.write_text(text, "utf-8")
    found = guess([path])
    assert {q.target for q in found.questions} == {*asked, "system"}
    [one] = run([path], mapping_of({"columns": tomllib.loads(found.toml)["columns"], "constants": {"system": "act"}}, "m.toml")).runs
    assert one.time_s - one.time_s[0] == pytest.approx(S, abs=1e-4)
    assert one.tension_in_n == pytest.approx(X, abs=1e-3) and one.tension_out_n == pytest.approx(Y, abs=1e-3)
