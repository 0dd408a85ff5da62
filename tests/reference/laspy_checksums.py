"""Writes checksums.tsv: what laspy (with lazrs), an independent reader, says of each scan.

    pip install 'laspy[lazrs]'
    python3 tests/reference/laspy_checksums.py ../shared/data > tests/reference/checksums.tsv

Columns: file, number of points, hash. The hash takes FNV-1a (64 bit) of each point's X, Y, Z (i32) and
red, green, blue, intensity (u16, 0 where the format has none), 20 bytes little-endian, and sums the
points' hashes, each times 2 * (its number) + 1, modulo 2^64: so the order of the points matters too.
"""

import pathlib
import sys

import laspy
import numpy as np


def checksum(las):
    columns = [np.ascontiguousarray(las[name], dtype="<i4") for name in ("X", "Y", "Z")]
    dimensions = set(las.point_format.dimension_names)
    for name in ("red", "green", "blue", "intensity"):
        found = las[name] if name in dimensions else np.zeros(len(las.points))
        columns.append(np.ascontiguousarray(found, dtype="<u2"))
    count = len(columns[0])
    rows = np.concatenate([c.view(np.uint8).reshape(count, c.itemsize) for c in columns], axis=1)
    with np.errstate(over="ignore"):
        hashes = np.full(count, 0xCBF29CE484222325, dtype=np.uint64)
        for byte in range(rows.shape[1]):
            hashes = (hashes ^ rows[:, byte].astype(np.uint64)) * np.uint64(0x100000001B3)
        weights = np.arange(count, dtype=np.uint64) * np.uint64(2) + np.uint64(1)
        return count, int((hashes * weights).sum(dtype=np.uint64))


def main():
    data = pathlib.Path(sys.argv[1])
    print("# file\tpoints\thash")
    for folder in ("formats", "scans"):
        for path in sorted((data / folder).iterdir()):
            count, value = checksum(laspy.read(path))
            print(f"{folder}/{path.name}\t{count}\t{value:016x}")


main()
