"""Writes colors.tsv: what laspy, an independent reader, says of the values that points are coloured by.

    pip install laspy lazrs
    python3 tests/reference/laspy_colors.py ../shared/data > tests/reference/colors.tsv

Columns: file, attribute, number of points with a value; the values between which all but 1 % at either end lie, and the
smallest and the largest; how many points have each value (of whole numbers; «-» for others); and the values of up to
60 records, evenly spread, «record=value», without those that are marked as no data.
"""

import pathlib
import sys

import laspy
import numpy as np

# Every point format, LAS and LAZ, with and without extra bytes.
FILES = [
    *(f"formats/pasture-10_points_with_extra_bytes_format_{n}.las" for n in range(11)),
    *(f"formats/pasture-10_points_format_{n}.laz" for n in range(9)),
    "formats/pdal-epsg_4326.las",
    "formats/laspy-vegetation_1_3.las",
    "formats/laspy-simple1_3.las",
    "formats/laspy-extra.laz",
    "formats/ctview-Semis_2021_0785_6378_LA93_IGN69_water.laz",
    "formats/laspy-1_4_w_evlr.las",
    "formats/laspy-simple_with_page.copc.laz",
    "formats/laspy-append-bug.laz",
    "formats/loaders.gl-pdrf9-1.4.laz",
    "formats/laspy-fullwave.laz",
    "formats/laspy-plane.laz",
    "scans/pdal-autzen_trim_7.las",
]
SMALL = ["intensity", "classification", "return-number", "number-of-returns", "point-source", "user-data"]


def values_of(las):
    """The values of each attribute, NaN where there is none."""
    yield "intensity", las.intensity
    yield "elevation", las.z
    yield "classification", las.classification
    yield "return-number", las.return_number
    yield "number-of-returns", las.number_of_returns
    yield "point-source", las.point_source_id
    yield "user-data", las.user_data
    if las.header.point_format.id < 6:
        yield "scan-angle", las.scan_angle_rank
    else:
        yield "scan-angle", las.scan_angle.astype(np.float64) * 0.006
    if las.header.point_format.id not in (0, 2):
        yield "gps-time", las.gps_time
    for dimension in las.point_format.extra_dimensions:
        # "ExtraBytes" is laspy's own name for bytes that the file says nothing of.
        if dimension.num_elements == 1 and dimension.dtype is not None and dimension.name != "ExtraBytes":
            values = np.array(las[dimension.name], np.float64)
            if dimension.no_data is not None:
                raw = las.points.array[dimension.name]
                values[raw == dimension.no_data] = np.nan
            yield f"extra:{dimension.name}", values


def lines(path, name):
    las = laspy.read(path)
    for attribute, values in values_of(las):
        values = np.array(values, np.float64)
        known = np.sort(values[~np.isnan(values)])
        if len(known) == 0:
            continue
        off = len(known) // 100
        clipped = [known[off], known[len(known) - 1 - off], known[0], known[-1]]
        counts = "-"
        if attribute in SMALL and attribute != "intensity":
            counts = " ".join(f"{int(v)}:{n}" for v, n in zip(*np.unique(known, return_counts=True)))
        step = max(len(values) // 60, 1)
        samples = [f"{i}={values[i]!r}" for i in range(0, len(values), step) if not np.isnan(values[i])]
        samples = " ".join(samples).replace("np.float64(", "").replace(")", "")
        yield "\t".join([name, attribute, str(len(known)), *(repr(float(v)) for v in clipped), counts, samples])


def main():
    data = pathlib.Path(sys.argv[1])
    print("file\tattribute\tpoints\tlow\thigh\tmin\tmax\tcounts\tsamples")
    for name in FILES:
        for line in lines(data / name, name):
            print(line)


if __name__ == "__main__":
    main()
