//! Everything that is decided before the first point is decoded: which files can be read, where their
//! points are, which grid they share, and which record numbers they get.

use std::{
    fs::File,
    path::{Path, PathBuf},
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
};

use super::{
    FileReport, OpenOptions, SourceError,
    bytes::read_vec_at,
    chunks::{Chunk, LazLayout},
    crs::{self, Crs},
    fields::Fields,
    grid::{self, FileGrid, Placement},
    header::{Header, xyz_at},
    inputs, laz,
    order::{self, FileOrder, Task},
    record::RecordReader,
    vlr::EVLR_HEADER,
    work::{PIECE_BYTES, READ_BYTES},
};
use crate::scene::{BATCH_POINTS, Bounds, ExtraDimension, FileFacts, RecordFacts, SceneFacts};

/// Positions that are looked at where the header's box is in doubt.
const SAMPLES: u64 = 256;

/// Extra bytes per point that are read at most: a batch of them takes 64 MiB. The header allows 65,505,
/// and a few bytes of layered LAZ stand for any number of them.
const MAX_EXTRA_BYTES: usize = 1_024;

/// Records that are looked at for a colour: each may cost a disk's seek.
const COLOR_SAMPLES: u64 = 16;

/// Where a file's points are.
pub enum Layout {
    /// Records of fixed length, one after the other.
    Las,
    Laz(LazLayout),
}

/// A file that will be read.
pub struct FilePlan {
    pub header: Header,
    pub layout: Layout,
    /// Points to decode: what the header promises, as far as the file can hold it.
    pub points: u64,
    pub reader: RecordReader,
    /// The box that the scene may rely on for a first view.
    pub bounds: Bounds,
    /// In which order it is read.
    pub order: FileOrder,
    /// Held open, for the first few files of a scene.
    pub file: Option<Arc<File>>,
    pub crs: Crs,
    pub extra_dimensions: Vec<ExtraDimension>,
    pub warnings: Vec<String>,
}

/// All that will be read, and a report for each input that cannot be.
pub struct Plan {
    pub facts: SceneFacts,
    pub files: Vec<FilePlan>,
    /// What the decoder threads do, in this order.
    pub tasks: Vec<Task>,
    pub failed: Vec<FileReport>,
}

/// Files that are held open at most; beyond that they are opened task by task. Many systems allow 1,024
/// open files, macOS 256.
const MAX_OPEN: usize = 128;

/// Lists the inputs, reads all headers, lays the grid, and puts the work in order.
pub fn make(paths: &[PathBuf], options: &OpenOptions, cancel: &AtomicBool) -> Result<Plan, SourceError> {
    let (paths, mut errors) = inputs::list(paths);
    let mut files: Vec<FilePlan> = Vec::new();
    let mut first_record = 0u64;
    for path in paths {
        if cancel.load(Ordering::Relaxed) {
            break;
        }
        match open_file(&path, options.fields, first_record, cancel) {
            Ok(mut file) => {
                first_record += file.points;
                file.file = file.file.filter(|_| files.len() < MAX_OPEN);
                files.push(file);
            }
            Err(error) => errors.push((path, error)),
        }
    }
    if files.is_empty() {
        let mut errors: Vec<SourceError> = errors.into_iter().map(|(_, e)| e).collect();
        return Err(if errors.len() == 1 { errors.remove(0) } else { SourceError::AllFailed { errors } });
    }
    let grids: Vec<FileGrid> = files.iter().map(FilePlan::grid).collect();
    // An empty file's scale and box say nothing.
    let used: Vec<FileGrid> = files.iter().zip(&grids).filter(|(f, _)| f.points > 0).map(|(_, g)| *g).collect();
    let (grid, mut warnings) = grid::choose(if used.is_empty() { &grids } else { &used });
    for (file, own) in files.iter_mut().zip(&grids) {
        file.reader.placement = Placement::new(own, &grid);
    }
    // An empty file's box is often all zeros: it must not pull the view away.
    let with_points = files.iter().filter(|f| f.points > 0).map(|f| f.bounds);
    let bounds = with_points.reduce(|a, b| a.union(&b)).unwrap_or(files[0].bounds);
    warnings.extend(crs::disagreement(&files.iter().map(FilePlan::named_crs).collect::<Vec<_>>()));
    let facts = SceneFacts { grid, bounds, files: files.iter().map(FilePlan::facts).collect(), warnings };
    let failed = errors.into_iter().map(|(path, error)| FileReport::not_opened(path, &error)).collect();
    let tasks = put_in_order(&mut files, options);
    Ok(Plan { facts, files, tasks, failed })
}

/// Decides each file's order, and that of the whole scene.
fn put_in_order(files: &mut [FilePlan], options: &OpenOptions) -> Vec<Task> {
    let keeping = files.iter().filter(|f| f.file.is_some() && matches!(f.layout, Layout::Laz(_))).count();
    let kept = order::MAX_KEPT / keeping.max(1) as u32;
    let mut orders: Vec<FileOrder> = files
        .iter()
        .map(|file| match &file.layout {
            Layout::Las => FileOrder::of_records(options.order, file.points),
            Layout::Laz(layout) => {
                // A kept decoder holds its file: beyond MAX_OPEN there would be too many.
                let keepable = file.file.is_some() && laz::keepable(layout, options.decoder);
                FileOrder::of_chunks(options.order, layout, keepable, kept)
            }
        })
        .collect();
    let tasks = order::schedule(options.order, &mut orders);
    for (file, order) in files.iter_mut().zip(orders) {
        file.order = order;
    }
    tasks
}

fn open_file(
    path: &Path,
    fields: Option<Fields>,
    first_record: u64,
    cancel: &AtomicBool,
) -> Result<FilePlan, SourceError> {
    let (mut header, file) = Header::read(path)?;
    let mut warnings = std::mem::take(&mut header.warnings);
    let (layout, points) = if header.compressed {
        let layout = LazLayout::read(&header, &file, &mut warnings, cancel)?;
        let points = layout.points();
        (Layout::Laz(layout), points)
    } else {
        (Layout::Las, las_points(&header, &mut warnings))
    };
    if first_record.saturating_add(points) > u64::from(u32::MAX) {
        return Err(SourceError::TooManyPoints { path: path.into(), points, before: first_record });
    }
    let bounds = promised_bounds(&header, &layout, points, &file, &mut warnings);
    let reader = RecordReader {
        layout: header.layout,
        fields: affordable(fields, &header, &mut warnings)
            .unwrap_or_else(|| automatic_fields(&header, &layout, points, &file)),
        placement: Placement::IDENTITY,
        bounds: reachable(&header).then(|| grid::box_in_steps(&header.bounds, header.scale, header.offset)).flatten(),
        first_record: first_record as u32,
    };
    let extra_dimensions = header.extra_dimensions(&file, &mut warnings);
    let crs = Crs::read(&file, header.all_vlrs()).unwrap_or_else(|e| {
        warnings.push(format!("cannot read the coordinate system: {e}"));
        Crs::default()
    });
    let (order, file) = (FileOrder::default(), Some(Arc::new(file)));
    Ok(FilePlan { header, layout, points, reader, bounds, order, file, crs, extra_dimensions, warnings })
}

impl FilePlan {
    /// True if nothing says where a chunk ends: decoding goes on into the next one, and gives garbage.
    pub fn ends_unknown(&self) -> bool {
        matches!(&self.layout, Layout::Laz(layout) if layout.ends_unknown())
    }

    /// True if its decoders are kept between preview and full pass.
    pub fn keeps_decoders(&self) -> bool {
        self.order.preview.starts_every > 0
    }

    /// Most heap memory that a thread needs to read it, without batches.
    pub fn thread_bytes(&self) -> u64 {
        match &self.layout {
            Layout::Las => READ_BYTES as u64 + self.header.record_length() as u64,
            Layout::Laz(layout) => {
                let chunk = layout.chunks.iter().map(|c| c.bytes).filter(|&b| b <= laz::MAX_CHUNK_BYTES).max();
                // Its buffers, and as many spare bytes.
                2 * chunk.unwrap_or(0) + PIECE_BYTES as u64 + laz::decoder_bytes(&layout.items)
            }
        }
    }

    /// Heap memory of its lists: chunks (twice, while the list grows), tasks, the header and its records.
    pub fn list_bytes(&self) -> u64 {
        const HEADER: usize = 4_096;
        const RECORD: usize = 256;
        let chunks = match &self.layout {
            Layout::Las => 0,
            Layout::Laz(layout) => layout.chunks.len() * (2 * size_of::<Chunk>() + 1),
        };
        let chunks = chunks + HEADER + self.header.all_vlrs().count() * RECORD;
        let tasks = self.points.div_ceil(BATCH_POINTS as u64) as usize * 4 * size_of::<Task>();
        (chunks + tasks + self.order.sequence.len() * size_of::<u32>()) as u64
    }

    fn grid(&self) -> FileGrid {
        FileGrid { scale: self.header.scale, offset: self.header.offset, bounds: self.bounds }
    }

    fn named_crs(&self) -> (String, Crs) {
        (self.header.path.display().to_string(), self.crs.clone())
    }

    fn facts(&self) -> FileFacts {
        FileFacts {
            path: self.header.path.clone(),
            first_record: self.reader.first_record,
            points_in_header: self.points,
            bounds: self.bounds,
            kind: self.header.kind(),
            metres_per_unit: self.crs.metres_per_unit(),
            record: RecordFacts {
                format: self.header.format,
                scan_angle_step: if self.reader.layout.extended { 0.006 } else { 1.0 },
                gps_clock: self.header.gps_clock(),
                has_intensities: self.reader.fields.intensity,
                extra_bytes: self.reader.layout.extra_bytes(),
                extra_dimensions: self.extra_dimensions.clone(),
                bytes_per_point: self.reader.bytes_per_point(),
            },
        }
    }
}

/// Records that an uncompressed file has room for, at most the header's count.
fn las_points(header: &Header, warnings: &mut Vec<String>) -> u64 {
    let (start, length) = (header.data_at(), header.record_length() as u64);
    let room = header.file_length.saturating_sub(start) / length;
    // Extended records and waveform packets lie behind the points. (A file of LAS 1.3 or later without
    // packets says zero.)
    let waves = header.raw.start_of_waveform_data_packet_record;
    let behind = header.evlrs.iter().map(|v| v.data_at - EVLR_HEADER).chain(waves).filter(|&at| at > start);
    let end = behind.min().unwrap_or(header.file_length).min(header.file_length);
    let before = (end - start.min(end)) / length;
    let points = header.points;
    if before > points {
        warnings
            .push(format!("the header counts {points} points, the file has room for {before}: the rest is not read"));
    } else if before < points.min(room) {
        warnings.push(format!(
            "the header counts {points} points, {before} fit before what follows them at byte {end}: \
             those after that may be garbage"
        ));
    }
    room.min(points)
}

/// True if the header's box makes sense and lies where the header's scale and offset can reach.
fn reachable(header: &Header) -> bool {
    let reach = |a: usize, x: f64| ((x - header.offset[a]) / header.scale[a]).abs() < 2f64.powi(33);
    header.bounds.is_sane() && (0..3).all(|a| reach(a, header.bounds.min[a]) && reach(a, header.bounds.max[a]))
}

/// The header's box, unless it is nonsense or most of some sampled points lie outside of it.
fn promised_bounds(header: &Header, layout: &Layout, points: u64, file: &File, warnings: &mut Vec<String>) -> Bounds {
    let sane = reachable(header);
    let world = |p: [i32; 3]| std::array::from_fn(|a| header.offset[a] + header.scale[a] * f64::from(p[a]));
    let slack: [f64; 3] = header.scale.map(|s| 0.51 * s.abs());
    let inside = |p: &[f64; 3]| {
        (0..3).all(|a| p[a] >= header.bounds.min[a] - slack[a] && p[a] <= header.bounds.max[a] + slack[a])
    };
    let first = sample(header, layout, points, file, 1);
    if points == 0 {
        return if sane { header.bounds } else { Bounds { min: header.offset, max: header.offset } };
    }
    if sane && first.iter().all(|&p| inside(&world(p))) {
        return header.bounds;
    }
    let sampled: Vec<[f64; 3]> = sample(header, layout, points, file, SAMPLES).into_iter().map(world).collect();
    let outside = sampled.iter().filter(|p| !inside(p)).count();
    if sane && 2 * outside <= sampled.len() {
        return header.bounds;
    }
    let around = sampled.iter().map(|&p| Bounds { min: p, max: p }).reduce(|a, b| a.union(&b));
    warnings.push(format!(
        "the header's box {:?} to {:?} does not hold the points: that of {} sampled points is used",
        header.bounds.min,
        header.bounds.max,
        sampled.len()
    ));
    around.unwrap_or(Bounds { min: header.offset, max: header.offset })
}

/// Positions of records that lie in the file uncompressed.
fn sample(header: &Header, layout: &Layout, points: u64, file: &File, count: u64) -> Vec<[i32; 3]> {
    raw_records(header, layout, points, count).filter_map(|at| xyz_at(file, at)).collect()
}

/// What [`ColorStats::rule`](crate::scene::ColorStats::rule) depends on: RGB; and intensity, unless some
/// uncompressed record has a colour, for then the rule never asks for it. (In layered LAZ, intensity is
/// about an eighth of the decoding.) Only if the chunk with that record turns out to be damaged, and
/// all others have no colour, is the file shown by elevation instead of intensity.
fn automatic_fields(header: &Header, layout: &Layout, points: u64, file: &File) -> Fields {
    let Some(rgb_at) = header.layout.rgb_at else { return Fields::COLORS };
    let colored = |at: u64| {
        let rgb = read_vec_at(file, at + rgb_at as u64, 6).unwrap_or_default();
        rgb.len() == 6 && rgb.iter().any(|&byte| byte != 0)
    };
    // Mostly the first one answers.
    let intensity = !raw_records(header, layout, points, COLOR_SAMPLES).any(colored);
    Fields { intensity, ..Fields::COLORS }
}

/// The fields asked for, without extra bytes where these are more than a batch can hold.
fn affordable(fields: Option<Fields>, header: &Header, warnings: &mut Vec<String>) -> Option<Fields> {
    let mut fields = fields?;
    let bytes = header.layout.extra_bytes();
    if fields.extra_bytes && bytes > MAX_EXTRA_BYTES {
        warnings.push(format!("{bytes} extra bytes per point are not read: expected {MAX_EXTRA_BYTES} at most"));
        fields.extra_bytes = false;
    }
    Some(fields)
}

/// File offsets of up to about `count` records that lie in the file uncompressed, from the first one on:
/// any record of a LAS file, the first of each LAZ chunk.
fn raw_records(header: &Header, layout: &Layout, points: u64, count: u64) -> Box<dyn Iterator<Item = u64>> {
    match layout {
        Layout::Las => {
            let count = count.min(points);
            let (start, step) = (header.data_at(), points / count.max(1) * header.record_length() as u64);
            Box::new((0..count).map(move |i| start + i * step))
        }
        Layout::Laz(layout) => {
            let step = layout.chunks.len().div_ceil(count as usize).max(1);
            let at: Vec<u64> = layout.chunks.iter().step_by(step).filter(|c| c.points > 0).map(|c| c.at).collect();
            Box::new(at.into_iter())
        }
    }
}
