//! `firstlight pick`.

use std::{path::PathBuf, sync::atomic::AtomicBool, time::Instant};

use clap::Args;

use super::{
    CliError, ExitStatus,
    look::{FilterArgs, ShapeArgs},
    point::{FormArgs, print},
    render::{BackendArg, backend_choice, progress_style, read_camera, tell_notes, with_help},
    say, values,
};
use crate::{
    headless::{self, Outputs, Picked, Settings, Stop},
    inspect::{Field, PointRecord, Value, shortest_f32},
    render::{INSERTION_POINTS, Look, MAX_REACH, Pick, PickAt, RasterChoice},
};

#[derive(Debug, Args)]
pub struct PickArgs {
    /// LAS and LAZ files, and folders of them
    #[arg(value_name = "IN", required = true)]
    inputs: Vec<PathBuf>,
    /// Column and row of a pixel, from 0 at the upper left; may be given several times
    #[arg(long, value_name = "X,Y", required = true, value_parser = values::parse_pixel)]
    at: Vec<[u32; 2]>,
    /// Take the nearest pixel that shows a point within so many pixels; 0: that pixel or nothing
    #[arg(long, value_name = "PX", default_value_t = 4, value_parser = clap::value_parser!(u32).range(0..=i64::from(MAX_REACH)))]
    reach: u32,
    /// Width and height of the picture, pixels
    #[arg(long, value_name = "WxH", default_value = "1600x900", value_parser = values::parse_size)]
    size: [u32; 2],
    /// Where to look from, as in `render`
    #[arg(long, value_name = "JSON|CAM.json")]
    camera: Option<PathBuf>,
    #[command(flatten)]
    form: FormArgs,
    /// How the GPU turns points into pixels, as in `render`
    #[arg(long, value_name = "auto|NAME", default_value = "auto", value_parser = values::parse_method)]
    method: RasterChoice,
    /// Where to draw; auto takes a GPU if there is one
    #[arg(long, value_enum, default_value_t)]
    backend: BackendArg,
    /// Fixes the order of the points in the store
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Decoder threads; by default one per core, less one
    #[arg(long, value_name = "N", value_parser = values::parse_threads)]
    threads: Option<usize>,
    #[command(flatten)]
    shape: ShapeArgs,
    #[command(flatten)]
    filter: FilterArgs,
}

impl PickArgs {
    /// What decides which points a picture shows; their colours do not.
    fn look(&self) -> Look {
        Look {
            point_size: self.shape.point_size().unwrap_or_default(),
            projection: self.shape.projection(),
            filter: self.filter.filter(),
            clip: self.filter.clip(),
            ..Default::default()
        }
    }
}

pub fn run(args: PickArgs, started: Instant) -> Result<ExitStatus, CliError> {
    let [width, height] = args.size;
    if let Some([x, y]) = args.at.iter().find(|[x, y]| *x >= width || *y >= height) {
        return Err(CliError::Usage(format!(
            "--at {x},{y}: the picture has {width}x{height} pixels, counted from 0; --size makes it larger"
        )));
    }
    let questions: Vec<PickAt> = args.at.iter().map(|&pixel| PickAt { pixel, reach: args.reach }).collect();
    let settings = Settings {
        outputs: Outputs::default(),
        size: args.size,
        camera: args.camera.as_deref().map(read_camera).transpose()?,
        backend: backend_choice(args.backend, args.method)?,
        method: args.method,
        encoding: None,
        fill: None,
        look: args.look(),
        seed: args.seed,
        insertion_points: INSERTION_POINTS,
        stop: Stop::Converged,
        brute_force: false,
        threads: args.threads,
        progress: progress_style(true),
        started,
        inputs: args.inputs,
    };
    let picked = headless::pick(&settings, &questions).map_err(with_help)?;
    let mut found = Vec::new();
    for (at, pick) in questions.iter().zip(&picked.picks) {
        match pick {
            Some(pick) => found.push(Some(sheet(&picked, pick)?)),
            None => {
                let [x, y] = at.pixel;
                say(&format!("firstlight: no point within {} pixels of {x},{y}", at.reach));
                found.push(None);
            }
        }
    }
    print(&args.form.text(&found))?;
    Ok(tell_notes(&picked.report, false))
}

/// What the picture and the file say of a picked point.
fn sheet(picked: &Picked, pick: &Pick) -> Result<super::point::Sheet, CliError> {
    let read = PointRecord::read_of_scene(&picked.scene, pick.record, &AtomicBool::new(false));
    let record = read.ok_or_else(|| CliError::Usage(format!("no file holds record {}", pick.record)))??;
    let [x, y] = pick.pixel;
    let depth = shortest_f32(pick.depth);
    let number = |name: &str, n: &dyn ToString| Field::new(name, Value::Number(n.to_string()));
    let fields = [number("pixel_x", &x), number("pixel_y", &y), number("depth", &depth), number("id", &pick.record)];
    let row = ("Pixel".to_owned(), format!("{x},{y}, id {}, depth {depth}", pick.record));
    Ok(super::point::Sheet {
        fields: fields.into_iter().chain(record.fields()).collect(),
        card: [row].into_iter().chain(record.card()).collect(),
    })
}
