"""Writes checksums.tsv: what laspy, an independent reader, says of each scan; LAZ is decoded by LASzip.

    pip install 'laspy[laszip]'
    python3 tests/reference/laspy_checksums.py ../shared/data > tests/reference/checksums.tsv

Columns: file, number of points, and a hash per attribute; «-» where the file's format does not have it.
A hash takes FNV-1a (64 bit) of each point's bytes, little-endian, and sums the points' hashes, each
times 2 * (its number) + 1, modulo 2^64: so the order of the points matters too. The bytes are

    color       X, Y, Z (i32), red, green, blue, intensity (u16, 0 where the format has none)
    returns     return number, and number of returns times 16 (u8)
    flags       byte 15 of LAS 1.4's formats: synthetic 1, key-point 2, withheld 4, overlap 8, scanner
                channel times 16, scan direction 64, edge of flight line 128 (u8)
    class       classification (u8)
    angle       scan angle, or its rank (i16)
    user        user data (u8)
    source      point source id (u16)
    time        GPS time (the f64's bits)
    nir         near infrared (u16)
    wave        the wave packet descriptor (29 bytes)
    extra       extra bytes, all of them
    values      value of each element of each extra dimension that has a type (f64), scaled and offset;
                no-data values are values
"""

import pathlib
import sys

import laspy
import numpy as np

SIZES = [1, 1, 2, 2, 4, 4, 8, 8, 4, 8]
STANDARD = [20, 28, 26, 34, 57, 63, 30, 36, 38, 59, 67]
WAVE = [
    ("wavepacket_index", "u1"),
    ("wavepacket_offset", "<u8"),
    ("wavepacket_size", "<u4"),
    ("return_point_wave_location", "<f4"),
    ("x_t", "<f4"),
    ("y_t", "<f4"),
    ("z_t", "<f4"),
]
FLAGS = [
    ("synthetic", 0),
    ("key_point", 1),
    ("withheld", 2),
    ("overlap", 3),
    ("scanner_channel", 4),
    ("scan_direction_flag", 6),
    ("edge_of_flight_line", 7),
]


def rows(column):
    """One row of bytes per point."""
    column = np.ascontiguousarray(column)
    return column.view(np.uint8).reshape(len(column), -1) if len(column) else np.zeros((0, 1), np.uint8)


def checksum(columns):
    if not columns:
        return "-"
    columns = np.concatenate([rows(c) for c in columns], axis=1)
    with np.errstate(over="ignore"):
        hashes = np.full(len(columns), 0xCBF29CE484222325, dtype=np.uint64)
        for byte in range(columns.shape[1]):
            hashes = (hashes ^ columns[:, byte].astype(np.uint64)) * np.uint64(0x100000001B3)
        weights = np.arange(len(columns), dtype=np.uint64) * np.uint64(2) + np.uint64(1)
        return f"{int((hashes * weights).sum(dtype=np.uint64)):016x}"


def extra_values(las, extra):
    """Per typed extra dimension, its values. laspy knows the dimensions of one list only."""
    values = []
    at = 0
    for vlr in las.header.vlrs.get("ExtraBytesVlr"):
        for entry in vlr.extra_bytes_structs:
            name, elements = entry.format_name(), max(0, entry.data_type - 1) // 10 + 1
            size = entry.options if entry.data_type == 0 else SIZES[(entry.data_type - 1) % 10] * elements
            if entry.data_type != 0:
                if name in las.point_format.extra_dimension_names:
                    value = np.asarray(las[name])
                else:
                    assert elements == 1 and entry.options & 0b11000 == 0
                    kind = "uiuiuiuiff"[entry.data_type - 1]
                    value = np.ascontiguousarray(extra[:, at : at + size]).view(f"<{kind}{size}")
                values.append(value.astype("<f8"))
            at += size
    return values


def columns(las):
    names = set(las.point_format.dimension_names)
    count = len(las.points)
    raw = las.points.array
    assert raw.dtype.itemsize == las.header.point_format.size

    def column(name, kind):
        return np.asarray(las[name] if name in names else np.zeros(count)).astype(kind)

    def present(name, kind):
        return [column(name, kind)] if name in names else []

    flags = sum(column(name, "u1").astype(int) << bit for name, bit in FLAGS)
    angle = "scan_angle" if "scan_angle" in names else "scan_angle_rank"
    standard = STANDARD[las.header.point_format.id]
    extra = np.frombuffer(raw.tobytes(), np.uint8).reshape(count, raw.dtype.itemsize)[:, standard:]
    colors = [column(name, "<u2") for name in ("red", "green", "blue", "intensity")]
    return {
        "color": [column(name, "<i4") for name in ("X", "Y", "Z")] + colors,
        "returns": [column("return_number", "u1") | column("number_of_returns", "u1") << 4],
        "flags": [flags.astype("u1")],
        "class": [column("classification", "u1")],
        "angle": [column(angle, "<i2")],
        "user": [column("user_data", "u1")],
        "source": [column("point_source_id", "<u2")],
        "time": present("gps_time", "<f8"),
        "nir": present("nir", "<u2"),
        "wave": [column(name, kind) for name, kind in WAVE] if "wavepacket_index" in names else [],
        "extra": [extra] if extra.shape[1] else [],
        "values": extra_values(las, extra),
    }


def main():
    data = pathlib.Path(sys.argv[1])
    head = True
    for folder in ("formats", "scans"):
        for path in sorted((data / folder).iterdir()):
            las = laspy.read(path, laz_backend=laspy.LazBackend.Laszip)
            found = columns(las)
            if head:
                print("# file", "points", *found, sep="\t")
                head = False
            print(f"{folder}/{path.name}", len(las.points), *map(checksum, found.values()), sep="\t")


main()
