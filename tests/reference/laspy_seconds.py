"""Prints how many seconds laspy takes to decode a file: another reader for `bench-ingest --against`.

    pip install laspy laszip lazrs
    python3 tests/reference/laspy_seconds.py laszip scan.laz             # LASzip, the C++ library
    python3 tests/reference/laspy_seconds.py lazrs scan.laz              # the laz crate, one thread
    python3 tests/reference/laspy_seconds.py lazrs-parallel scan.laz     # the laz crate, rayon's threads
    python3 tests/reference/laspy_seconds.py laszip xyz,rgb scan.laz     # layered files: only these fields

Points come chunk by chunk, as raw records; nothing is converted to columns (of a file that is not
compressed it is only read, then). Opening the file is counted, starting Python and importing laspy
are not. The last line is the seconds; lines before it say the points and the processor time.
"""

import argparse
import time

import laspy
from laspy import DecompressionSelection, LazBackend

BACKENDS = {
    "laszip": LazBackend.Laszip,
    "lazrs": LazBackend.Lazrs,
    "lazrs-parallel": LazBackend.LazrsParallel,
}
FIELDS = {
    "xyz": DecompressionSelection.Z,
    "rgb": DecompressionSelection.RGB,
    "nir": DecompressionSelection.NIR,
    "intensity": DecompressionSelection.INTENSITY,
    "classification": DecompressionSelection.CLASSIFICATION,
    "gps_time": DecompressionSelection.GPS_TIME,
    "all": DecompressionSelection.all(),
    # What this program decodes for its automatic colours.
    "colors": DecompressionSelection.Z | DecompressionSelection.RGB | DecompressionSelection.INTENSITY,
}
# As many points as LASzip puts into a chunk: one call per chunk.
POINTS_PER_CALL = 50_000


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("backend", choices=BACKENDS)
    parser.add_argument("fields", nargs="?", default="all", help="some of: " + ", ".join(FIELDS))
    parser.add_argument("file")
    args = parser.parse_args()
    backend = BACKENDS[args.backend]
    if not backend.is_available():
        parser.error(f"laspy cannot use {args.backend}: pip install {args.backend.split('-')[0]}")
    # x, y and the return numbers: what everything else is decoded after.
    selection = DecompressionSelection.base()
    for name in args.fields.split(","):
        if name not in FIELDS:
            parser.error(f"unknown field {name}: expected some of {', '.join(FIELDS)}")
        selection |= FIELDS[name]

    points = 0
    begin, begin_processor = time.perf_counter(), time.process_time()
    with laspy.open(args.file, laz_backend=backend, decompression_selection=selection) as reader:
        for chunk in reader.chunk_iterator(POINTS_PER_CALL):
            points += len(chunk)
    seconds, processor = time.perf_counter() - begin, time.process_time() - begin_processor
    print("points", points)
    print(f"processor {processor:.6f}")
    print(f"{seconds:.6f}")


main()
