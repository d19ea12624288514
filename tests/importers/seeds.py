"""Small valid recordings of the same two runs in every format, written by other people's libraries."""

from __future__ import annotations

import io
import json
import sqlite3
import struct
from pathlib import Path

import numpy as np

N = 120


def signals(n: int = N) -> dict[str, np.ndarray]:
    """Return a slow loop: input, and an output that follows with slope 0.6."""
    t = np.arange(n) * 0.01
    x = 5 + 2 * np.sin(2 * np.pi * t)
    return {"time_s": t, "tension_in_n": x, "tension_out_n": 0.6 * x + 0.25}


def text(folder: Path) -> Path:
    path = folder / "seed.csv"
    s = signals()
    rows = ["run_id,system,time_s,tension_in_n,tension_out_n"]
    rows += [f"r1,act,{a!r},{b!r},{c!r}" for a, b, c in zip(*(v.tolist() for v in s.values()), strict=True)]
    path.write_text("\n".join(rows) + "\n")
    return path


def parquet(folder: Path) -> Path:
    import pandas as pd

    path = folder / "seed.parquet"
    pd.DataFrame({**signals(), "run_id": "r1", "system": "act"}).to_parquet(path)
    return path


def mat5(folder: Path) -> Path:
    from scipy.io import savemat

    path = folder / "seed.mat"
    savemat(path, {**signals(), "run_id": "r1", "system": "act"}, do_compression=True)
    return path


def hdf5(folder: Path) -> Path:
    import h5py

    path = folder / "seed.h5"
    with h5py.File(path, "w") as file:
        for name, values in signals().items():
            file.create_dataset(name, data=values, compression="gzip", chunks=(50,))
        file["run_id"], file["system"] = "r1", "act"
    return path


def mat73(folder: Path) -> Path:
    import h5py

    path = folder / "seed73.mat"
    with h5py.File(path, "w", userblock_size=512) as file:
        for name, values in signals().items():
            file[name] = values[None, :]
        for name, word in (("run_id", "r1"), ("system", "act")):
            file[name] = np.array([[ord(c)] for c in word], np.uint16)
            file[name].attrs["MATLAB_class"] = np.bytes_("char")
    with open(path, "r+b") as raw:
        raw.write(b"MATLAB 7.3 MAT-file, Platform: test".ljust(124) + b"\x00\x02IM")
    return path


def npz(folder: Path) -> Path:
    path = folder / "seed.npz"
    np.savez_compressed(path, **signals(), run_id="r1", system="act")
    return path


def tdms(folder: Path) -> Path:
    from nptdms import ChannelObject, TdmsWriter

    path = folder / "seed.tdms"
    with TdmsWriter(path) as writer:
        labels = [ChannelObject("run", k, [v] * N) for k, v in (("run_id", "r1"), ("system", "act"))]
        writer.write_segment([ChannelObject("run", k, v) for k, v in signals().items()] + labels)
    return path


def mcap(folder: Path) -> Path:
    from mcap.writer import CompressionType, Writer

    path = folder / "seed.mcap"
    with open(path, "wb") as file:
        writer = Writer(file, compression=CompressionType.ZSTD)
        writer.start()
        schema = writer.register_schema("log", "jsonschema", b'{"type":"object"}')
        channel = writer.register_channel("/log", "json", schema)
        for row in zip(*(v.tolist() for v in signals().values()), strict=True):
            message = dict(zip(signals(1), row, strict=True)) | {"run_id": "r1", "system": "act"}
            at = round(row[0] * 1e9)
            writer.add_message(channel, at, json.dumps(message).encode(), at)
        writer.finish()
    return path


def rosbag1(folder: Path) -> Path:
    from rosbags.rosbag1 import Writer
    from rosbags.typesys import Stores, get_typestore

    path = folder / "seed.bag"
    path.unlink(missing_ok=True)
    store = get_typestore(Stores.ROS1_NOETIC)
    kind = "geometry_msgs/msg/Vector3"
    bag = Writer(path)
    bag.set_compression(Writer.CompressionFormat.BZ2)
    with bag as writer:
        connection = writer.add_connection("/tension", kind, typestore=store)
        for t, x, y in zip(*(v.tolist() for v in signals().values()), strict=True):
            message = store.types[kind](x=x, y=y, z=0.0)
            writer.write(connection, 1_700_000_000_000_000_000 + round(t * 1e9), store.serialize_ros1(message, kind))
    return path


def rosbag2(folder: Path, definitions: bool = False) -> Path:
    path = folder / "seed.db3"
    path.unlink(missing_ok=True)
    base = sqlite3.connect(path)
    base.execute("CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, serialization_format TEXT, qos TEXT)")
    base.execute("CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, data BLOB)")
    base.execute("INSERT INTO topics VALUES (1, '/tension', 'geometry_msgs/msg/Vector3Stamped', 'cdr', '')")
    for t, x, y in zip(*(v.tolist() for v in signals().values()), strict=True):
        at = 1_700_000_000_000_000_000 + round(t * 1e9)
        # stamp, frame_id "a", padding to 8 behind the 4-byte CDR header, three doubles
        head = struct.pack("<iI", at // 10**9, at % 10**9) + struct.pack("<I", 2) + b"a\0" + b"\0\0"
        body = head + struct.pack("<ddd", x, y, 0.0)
        base.execute("INSERT INTO messages (topic_id, timestamp, data) VALUES (1, ?, ?)", (at, b"\0\1\0\0" + body))
    base.commit()
    base.close()
    return path


WRITERS = {f.__name__: f for f in (text, parquet, mat5, mat73, hdf5, npz, tdms, mcap, rosbag1, rosbag2)}
SHORT = {
    "rosbag1": "tension_in_n=/tension.x:N,tension_out_n=/tension.y:N,system=act",
    "rosbag2": "tension_in_n=/tension.vector.x:N,tension_out_n=/tension.vector.y:N,system=act",
}


def seed_bytes(name: str) -> tuple[bytes, str]:
    """Return the bytes and the file suffix of the valid recording of a format."""
    import tempfile

    with tempfile.TemporaryDirectory() as folder:
        path = WRITERS[name](Path(folder))
        return io.BytesIO(path.read_bytes()).getvalue(), path.suffix
