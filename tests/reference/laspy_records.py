"""Writes records.tsv: what laspy, an independent reader, says of a few records of each scan; LAZ is decoded by LASzip.

    pip install 'laspy[laszip]'
    python3 tests/reference/laspy_records.py ../shared/data > tests/reference/records.tsv

Columns: file, record (from 0), and then a name=value for each field, by the names of `firstlight point --json`.
Coordinates and scaled values are decimal: what scale and offset are in their shortest form, times the number stored.
"""

import pathlib
import struct
import sys
from decimal import Decimal, getcontext

import laspy
import numpy as np

getcontext().prec = 400

KINDS = "BbHhIiQqfd"
STANDARD = [20, 28, 26, 34, 57, 63, 30, 36, 38, 59, 67]
FIELDS = {
    "X": "X",
    "Y": "Y",
    "Z": "Z",
    "intensity": "intensity",
    "return_number": "return_number",
    "number_of_returns": "number_of_returns",
    "synthetic": "synthetic",
    "key_point": "key_point",
    "withheld": "withheld",
    "overlap": "overlap",
    "scanner_channel": "scanner_channel",
    "scan_direction_flag": "scan_direction",
    "edge_of_flight_line": "edge_of_flight_line",
    "classification": "classification",
    "scan_angle": "scan_angle",
    "scan_angle_rank": "scan_angle",
    "user_data": "user_data",
    "point_source_id": "point_source_id",
    "gps_time": "gps_time",
    "red": "red",
    "green": "green",
    "blue": "blue",
    "nir": "nir",
    "wavepacket_index": "wave_descriptor",
    "wavepacket_offset": "wave_offset",
    "wavepacket_size": "wave_size",
    "return_point_wave_location": "wave_return_point",
    "x_t": "wave_dx",
    "y_t": "wave_dy",
    "z_t": "wave_dz",
}


def decimal(number):
    return Decimal(repr(float(number)).removesuffix(".0"))


def scaled(number, scale, offset):
    return format(Decimal(str(number)) * decimal(scale) + decimal(offset), "f")


def text(value):
    return str(value) if isinstance(value, np.float32) else repr(value.item())


def extra(las, raw):
    """Per typed extra dimension: its value, and what is stored where that is something else."""
    at = 0
    for vlr in las.header.vlrs.get("ExtraBytesVlr"):
        for entry in vlr.extra_bytes_structs:
            name, elements = entry.format_name(), max(0, entry.data_type - 1) // 10 + 1
            if entry.data_type == 0:
                yield f"extra:{name}", raw[at : at + entry.options].hex()
                at += entry.options
                continue
            kind = KINDS[(entry.data_type - 1) % 10]
            size = struct.calcsize("<" + kind)
            body = bytes(entry)
            for i in range(elements):
                number = struct.unpack_from("<" + kind, raw, at + i * size)[0]
                shown = str(np.float32(number)) if kind == "f" else repr(number)
                label = f"extra:{name}" if elements == 1 else f"extra:{name}[{i}]"
                wide = "d" if kind in "fd" else "q" if kind in "bhiq" else "Q"
                no_data = struct.unpack_from("<" + wide, body, 40 + 8 * i)[0]
                is_scaled = entry.options & 0b11000 != 0
                if entry.options & 1 and number == no_data:
                    yield label, ""
                    yield f"{label}:raw", shown
                elif is_scaled:
                    scale = struct.unpack_from("<d", body, 112 + 8 * i)[0] if entry.options & 0b1000 else 1
                    offset = struct.unpack_from("<d", body, 136 + 8 * i)[0] if entry.options & 0b10000 else 0
                    yield label, scaled(shown, scale, offset)
                    yield f"{label}:raw", shown
                else:
                    yield label, shown
            at += size * elements


def fields(las, names, record):
    for name, own in FIELDS.items():
        if name in names:
            yield own, text(np.asarray(las[name][record : record + 1])[0])
    for axis, own in enumerate("xyz"):
        number = np.asarray(las["XYZ"[axis]][record : record + 1])[0].item()
        yield own, scaled(number, las.header.scales[axis], las.header.offsets[axis])
    raw = las.points.array[record : record + 1].tobytes()
    yield from extra(las, raw[STANDARD[las.header.point_format.id] :])


def main():
    data = pathlib.Path(sys.argv[1])
    print("# file", "record", "name=value, …", sep="\t")
    for folder in ("formats", "scans"):
        for path in sorted((data / folder).iterdir()):
            las = laspy.read(path, laz_backend=laspy.LazBackend.Laszip)
            names, count = set(las.point_format.dimension_names), len(las.points)
            for record in sorted({0, count // 3, count * 5 // 7, count - 1} if count else {}):
                found = [f"{name}={value}" for name, value in fields(las, names, record)]
                print(f"{folder}/{path.name}", record, *found, sep="\t")


main()
