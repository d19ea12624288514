"""Files made to hurt: bombs, endless lines, lying headers, links that lead out."""

from __future__ import annotations

import io
import struct
import zipfile
import zlib
from pathlib import Path

import h5py
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
import scipy.io
from seeds import mcap, signals
from spent import spent_s

from sstl_cli.core.errors import SstlError
from sstl_cli.importers import base, mat5
from sstl_cli.importers.mapping import Mapping
from sstl_cli.steps.import_ import run


def refused(path: Path, seconds: float = 10.0) -> str:
    # a reader that hangs spends nothing, but ends with another code: E317
    started = spent_s()
    with pytest.raises(SstlError) as caught:
        list(run([path], Mapping()).runs)
    assert spent_s() - started < seconds
    return caught.value.line()


def npy_header(shape: str) -> bytes:
    text = f"{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}".ljust(117) + "\n"
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(text)) + text.encode()


def archive(path: Path, members: dict[str, bytes]) -> Path:
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as file:
        for name, data in members.items():
            file.writestr(name, data)
    return path


def test_npz_bomb(tmp_path: Path) -> None:
    zeros = npy_header("(20000000,)") + bytes(160_000_000)
    path = archive(tmp_path / "b.npz", {f"{n}.npy": zeros for n in ("time_s", "tension_in_n", "tension_out_n")})
    assert path.stat().st_size < 2_000_000
    assert "E312" in refused(path)


@pytest.mark.parametrize("shape", ["(1000000000,)", "(-5,)", "(99999999999999999999,)", "(1000000,1000000)"])
def test_npz_header_lies(shape: str, tmp_path: Path) -> None:
    data = npy_header(shape) + bytes(800)
    path = archive(tmp_path / "b.npz", {f"{n}.npy": data for n in ("time_s", "tension_in_n", "tension_out_n")})
    assert "declares" in refused(path) or "E310" in refused(path)


def test_a_file_of_too_many_channels_says_so(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # the channel that is asked for would be among those left out
    monkeypatch.setattr(base, "MAX_CHANNELS", 20)
    monkeypatch.setattr(mat5, "MAX_CHANNELS", 20)
    table = {
        **{f"a{i:03d}": np.arange(40.0) for i in range(30)},
        **{n: np.arange(40.0) for n in ("time_s", "tension_in_n", "tension_out_n")},
    }
    np.savez(tmp_path / "m.npz", **table)
    scipy.io.savemat(tmp_path / "five.mat", table)
    with h5py.File(tmp_path / "datasets.h5", "w") as file:
        for name, values in table.items():
            file[name] = values
    with h5py.File(tmp_path / "groups.h5", "w") as file:
        for name, values in table.items():
            file[f"{name}/of"] = values
    pq.write_table(pa.table(table), tmp_path / "p.parquet")
    for path in tmp_path.iterdir():
        assert "[E324]" in (told := refused(path)) and "holds more than 20" in told and str(path) in told


def test_npz_pickle_is_never_loaded(tmp_path: Path) -> None:
    np.savez(tmp_path / "p.npz", time_s=np.array([object(), {}], dtype=object), tension_in_n=np.zeros(2), tension_out_n=np.ones(2))
    assert "pickled" in refused(tmp_path / "p.npz")


@pytest.mark.parametrize("name", ["../../etc/x.npy", "/etc/x.npy", "C:\\x.npy"])
def test_names_that_lead_out(name: str, tmp_path: Path) -> None:
    buffer = io.BytesIO()
    np.save(buffer, np.zeros(3))
    assert "leads out" in refused(archive(tmp_path / "n.npz", {name: buffer.getvalue()}))


def test_links_in_archives(tmp_path: Path) -> None:
    info = zipfile.ZipInfo("time_s.npy")
    info.external_attr = 0o120777 << 16
    with zipfile.ZipFile(tmp_path / "l.npz", "w") as file:
        file.writestr(info, "/etc/passwd")
    assert "is a link" in refused(tmp_path / "l.npz")


def test_gigabyte_line(tmp_path: Path) -> None:
    path = tmp_path / "long.csv"
    with open(path, "wb") as file:
        file.write(b"time_s,tension_in_n,tension_out_n,system\n0,1,2,act\n1,2,3,act\n" + b"2,3,4,act\n" * 600_000)
        file.seek(1_000_000_000, 1)
        file.write(b"x")
    assert "longer than 1 MiB" in refused(path)
    path.write_bytes(b"1" * 3_000_000)
    assert "longer than 1 MiB" in refused(path)


def mat_element(kind: int, body: bytes) -> bytes:
    return struct.pack("<II", kind, len(body)) + body + bytes(-len(body) % 8)


def mat_file(body: bytes) -> bytes:
    return b"MATLAB 5.0 MAT-file".ljust(124) + b"\x00\x01IM" + body


def test_matlab_cell_that_declares_a_billion(tmp_path: Path) -> None:
    inner = mat_element(6, struct.pack("<II", 1, 0)) + mat_element(5, struct.pack("<ii", 1, 1_000_000_000)) + mat_element(1, b"a")
    (tmp_path / "c.mat").write_bytes(mat_file(mat_element(14, inner)))
    assert "declares" in refused(tmp_path / "c.mat")


def test_matlab_bomb(tmp_path: Path) -> None:
    worker = zlib.compressobj(9)
    packed = b"".join(worker.compress(bytes(1 << 24)) for _ in range(40)) + worker.flush()
    (tmp_path / "z.mat").write_bytes(mat_file(struct.pack("<II", 15, len(packed)) + packed))
    assert "E312" in refused(tmp_path / "z.mat")


def test_matlab_wrong_endian_mark(tmp_path: Path) -> None:
    from scipy.io import savemat

    savemat(tmp_path / "e.mat", signals())
    data = bytearray((tmp_path / "e.mat").read_bytes())
    data[126:128] = b"MI"
    (tmp_path / "e.mat").write_bytes(data)
    assert "E310" in refused(tmp_path / "e.mat")


def test_hdf5_that_declares_a_billion_rows_and_stores_none(tmp_path: Path) -> None:
    import h5py

    with h5py.File(tmp_path / "b.h5", "w") as file:
        for name in signals():
            file.create_dataset(name, (10**9,), "f8", chunks=(1000,))
        file["system"] = "act"
    assert "E312" in refused(tmp_path / "b.h5")


def test_hdf5_links_out(tmp_path: Path) -> None:
    import h5py

    with h5py.File(tmp_path / "l.h5", "w") as file:
        file["time_s"] = h5py.ExternalLink("/etc/secret.h5", "/x")
    assert "link to another file" in refused(tmp_path / "l.h5")
    with h5py.File(tmp_path / "x.h5", "w") as file:
        file.create_dataset("time_s", (10,), "f8", external=[("/etc/hostname", 0, 80)])
    assert "another file" in refused(tmp_path / "x.h5")


@pytest.mark.parametrize("suffix", ["h5", "mat"])
def test_a_group_that_holds_itself_is_read_once(suffix: str, tmp_path: Path) -> None:
    import h5py

    path = tmp_path / f"g.{suffix}"
    with h5py.File(path, "w", userblock_size=512) as file:
        group = file.create_group("log/inner")
        for name, values in signals().items():
            group[name] = values
        group["again"], group["above"] = group, file["log"]
        file["second"] = file["log"]
    if suffix == "mat":
        with path.open("r+b") as raw:
            raw.write(b"MATLAB 7.3 MAT-file".ljust(124) + b"\x00\x02IM")
    # a second name is no circle
    result = run([path], Mapping.model_validate({"constants": {"system": "act"}}))
    assert len(list(result.runs)) == 2


def test_hdf5_chunk_that_would_be_unpacked_again_for_every_block(tmp_path: Path) -> None:
    h5py = pytest.importorskip("h5py")
    with h5py.File(tmp_path / "b.h5", "w") as file:
        for name in ("time_s", "tension_in_n", "tension_out_n"):
            file.create_dataset(name, (9_000_000,), "f8", chunks=(9_000_000,), compression="gzip")[:1] = 1.0
        file["pad"] = np.random.default_rng(0).integers(0, 255, 600_000, np.uint8)
    line = refused(tmp_path / "b.h5")
    assert "E312" in line and "chunks of 7.2e+07 bytes; at most 64 MiB" in line


def test_mcap_chunk_bomb(tmp_path: Path) -> None:
    data = mcap(tmp_path).read_bytes()
    # the chunk record: opcode 6, length, start, end, then the size it claims to unpack to
    at = data.index(b"\x06", 8)
    while struct.unpack_from("<Q", data, at + 1)[0] > len(data):
        at = data.index(b"\x06", at + 1)
    lying = data[: at + 25] + struct.pack("<Q", 1 << 40) + data[at + 33 :]
    (tmp_path / "b.mcap").write_bytes(lying)
    assert "E312" in refused(tmp_path / "b.mcap")


def test_endless_sql_view(tmp_path: Path) -> None:
    import sqlite3

    base = sqlite3.connect(tmp_path / "v.db3")
    base.execute("CREATE TABLE topics(id, name, type, serialization_format)")
    base.execute(
        "CREATE VIEW messages AS WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n) "
        "SELECT i AS id, 1 AS topic_id, i AS timestamp, x'00' AS data FROM n"
    )
    base.commit()
    base.close()
    assert "without topics and messages" in refused(tmp_path / "v.db3")


@pytest.mark.parametrize("suffix", [".parquet", ".mat", ".h5", ".npz", ".tdms", ".mcap", ".bag", ".db3"])
def test_text_with_a_wrong_name_and_noise(suffix: str, tmp_path: Path) -> None:
    noise = np.random.default_rng(1).integers(0, 256, 5000, dtype=np.uint8).tobytes()
    (tmp_path / f"n{suffix}").write_bytes(noise)
    assert "E304" in refused(tmp_path / f"n{suffix}")


def test_utf16_binary_and_ragged_headers(tmp_path: Path) -> None:
    path = tmp_path / "x.csv"
    path.write_bytes("time_s,tension_in_n\n0,1\n".encode("utf-16"))
    assert "misses column 'tension_out_n'" in refused(path)
    path.write_bytes(b"a,b,c,d\n1,2,3\n2,3,4\n")
    assert "header names 4 columns" in refused(path)
    path.write_bytes(b"," * 30_000 + b"\n" + b"1," * 30_000 + b"\n")
    assert "columns" in refused(path)
