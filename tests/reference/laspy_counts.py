"""Writes filter_counts.tsv: how many points of a scan laspy, an independent reader, finds that pass filters.

    pip install laspy lazrs
    python3 tests/reference/laspy_counts.py ../shared/data > tests/reference/filter_counts.tsv

Columns: file, options as `firstlight render` takes them, points that pass. Borders come from each scan's own values.
"""

import pathlib
import sys

import laspy
import numpy as np

SCANS = [
    "formats/ctview-Semis_2021_0785_6378_LA93_IGN69_water.laz",
    "formats/laspy-fullwave.laz",
    "formats/laspy-simple1_3.las",
    "formats/laspy-vegetation_1_3.las",
    "formats/las-rs-extrabytes.laz",
    "formats/loaders.gl-pdrf9-1.4.las",
    "formats/pasture-10_points_with_extra_bytes_format_5.las",
    "formats/pdal-epsg_4326.las",
    "scans/laszip4j-500m_5460_59370_IM2023_subset.laz",
    "scans/pdal-autzen_trim.laz",
    "scans/pdal-autzen_trim_7.las",
    "scans/potree-lion_takanawa.copc.laz",
]
NAMES = {
    "intensity": "intensity",
    "class": "classification",
    "return": "return_number",
    "returns": "number_of_returns",
    "source": "point_source_id",
    "user-data": "user_data",
}


def short(x):
    """As few digits as bring the number back."""
    return repr(int(x)) if x == int(x) else repr(float(x))


def between(values, low=25, high=75):
    low, high = np.percentile(values, [low, high], method="nearest")
    return float(low), float(high), (values >= low) & (values <= high)


def coordinate(las, axis, low, high):
    """Raw integers decide, so that a border with the file's digits is met."""
    scale, offset = las.header.scales[axis], las.header.offsets[axis]
    steps = (las.X, las.Y, las.Z)[axis].astype(np.int64)
    low, high = np.ceil((low - offset) / scale - 1e-3), np.floor((high - offset) / scale + 1e-3)
    return (steps >= low) & (steps <= high)


def cases(las):
    dims = set(las.point_format.dimension_names)
    for name, dim in NAMES.items():
        values = np.asarray(las[dim]).astype(np.int64)
        common = np.unique(values)[np.argsort(-np.unique(values, return_counts=True)[1])][:3]
        low, high, mask = between(values)
        yield [f"--filter {name}={short(low)}..{short(high)}"], mask
        yield [f"--filter {name}={','.join(short(x) for x in common)}"], np.isin(values, common)
        yield [f"--filter {name}!={short(common[0])}"], values != common[0]
        yield [f"--filter {name}={short(high)}.."], values >= high
    if "scan_angle" in dims:
        # In steps, so that rounding decides nothing.
        steps = np.asarray(las["scan_angle"]).astype(np.int64)
        step = 0.006
    else:
        steps = np.asarray(las["scan_angle_rank"]).astype(np.int64)
        step = 1.0
    low, high, mask = between(steps, 10, 60)
    yield [f"--filter scan-angle={short(round(low * step, 3))}..{short(round(high * step, 3))}"], mask
    if "gps_time" in dims:
        low, high, mask = between(np.asarray(las.gps_time))
        yield [f"--filter gps-time={short(low)}..{short(high)}"], mask
        yield [f"--filter gps-time=..{short(high)}"], np.asarray(las.gps_time) <= high
    for dim in las.point_format.extra_dimensions:
        values = np.asarray(las[dim.name])
        if values.ndim == 1 and dim.no_data is None and np.isfinite(values.astype(float)).all():
            low, high, mask = between(values.astype(float))
            if " " not in dim.name:
                yield [f"--filter extra:{dim.name}={short(low)}..{short(high)}"], mask
    p = np.stack([las.x, las.y, las.z], axis=1)
    low, high = np.percentile(p, [20, 75], axis=0, method="nearest")
    low, high = [np.round(border, 9) for border in (low, high)]
    inside = [coordinate(las, axis, low[axis], high[axis]) for axis in range(3)]
    yield [f"--filter elevation={short(low[2])}..{short(high[2])}"], inside[2]
    box = ",".join(short(x) for x in [*low, *high])
    yield [f"--clip {box}"], inside[0] & inside[1] & inside[2]
    values = np.asarray(las.intensity)
    brightest = int(values.max())
    yield [f"--clip {box}", f"--filter intensity!={brightest}"], inside[0] & inside[1] & inside[2] & (values != brightest)
    size = high - low
    if (size > 0).all():
        center, (sin, cos) = (low + high) / 2, (np.sin(np.radians(30)), np.cos(np.radians(30)))
        d = p - center
        u, v = d[:, 0] * cos + d[:, 1] * sin, d[:, 1] * cos - d[:, 0] * sin
        margins = [np.abs(u) - size[0] / 2, np.abs(v) - size[1] / 2]
        if min(np.abs(m).min() for m in margins) > las.header.scales.max() * 2e-3:
            yield [f"--clip {box},30"], (margins[0] <= 0) & (margins[1] <= 0) & inside[2]
        normal, thickness = np.array([3.0, -4.0, 0.5]), float(np.round(size[:2].max() / 4, 3))
        margin = np.abs(d @ normal) / np.linalg.norm(normal) - thickness / 2
        if np.abs(margin).min() > las.header.scales.max() * 2e-3:
            slab = ",".join(short(x) for x in [*center, *normal, thickness])
            yield [f"--slab {slab}"], margin <= 0


def main(folder):
    print("# file\toptions\tpoints")
    for scan in SCANS:
        las = laspy.read(pathlib.Path(folder) / scan)
        for options, mask in cases(las):
            print(scan, " ".join(options), int(mask.sum()), sep="\t")


main(sys.argv[1])
