//! The options of how a scene is shown, the same for the window and for `render`.

use clap::{ArgMatches, Args, parser::ValueSource};

use super::values;
use crate::render::{
    CLIP_PERCENT, Clause, Clip, ClipBox, ColorBy, ColorMap, Coloring, Decor, Filter, Look, PointSize, Projection,
    Shading, Slab, Tone,
};

/// The heading of the options here that are not under another.
const HEADING: &str = "How it looks";

/// The options that say where points are in a picture, and how large.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = HEADING)]
pub struct ShapeArgs {
    /// Width of a point: pixels, 1 to 8, or a size such as 0.05m, 0.2ft or 0.05u (the file's unit), drawn as large as
    /// it is from there (up to 32 pixels); m and ft are the file's unit where it does not say how long that is; by
    /// default 1 in a picture and 2 in the window
    #[arg(long, value_name = "PX|0.05m|0.2ft|0.05u")]
    point_size: Option<PointSize>,
    /// Without perspective: everything looks as large as at the camera's target
    #[arg(long)]
    orthographic: bool,
}

impl ShapeArgs {
    /// If one is given.
    pub fn point_size(&self) -> Option<PointSize> {
        self.point_size
    }

    pub fn projection(&self) -> Projection {
        if self.orthographic { Projection::Orthographic } else { Projection::Perspective }
    }
}

/// All options of a [`Look`]. Their headings hold for what follows: an option that is none of them stands before.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = HEADING)]
pub struct LookArgs {
    #[command(flatten)]
    shape: ShapeArgs,
    /// Strength of eye-dome lighting; 0 turns it off
    #[arg(long, value_name = "STRENGTH", default_value_t = Shading::default().edl_strength, value_parser = values::parse_strength, allow_negative_numbers = true)]
    edl: f32,
    /// High-quality shading: each pixel shows the mean colour of all points within 1 % behind its nearest
    /// (not with attributes that are neither rgb, intensity, elevation nor file)
    #[arg(long)]
    hq: bool,
    /// Give small holes in surfaces the colour of a point beside them; records and depths stay as they are
    #[arg(long)]
    fill_holes: bool,
    /// Colour where no point is; by default #181c22
    #[arg(long, value_name = "#RRGGBB", value_parser = values::parse_color)]
    background: Option<[u8; 3]>,
    /// Draw over the picture: the scene's bounding box, a scale bar, a north arrow, what the colours mean; none:
    /// nothing, also where the window remembers some
    #[arg(long, value_name = "box,scale,north,legend", value_parser = values::named::<Decor>(Decor::names), hide_possible_values = true)]
    decorate: Option<Decor>,
    #[command(flatten)]
    filter: FilterArgs,
    #[command(flatten)]
    color: ColorArgs,
}

/// The options of what is shown.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "What is shown")]
pub struct FilterArgs {
    /// Show only points whose attribute has one of these values: class=2,6 or class!=7 or elevation=10..55.5 or
    /// return=last or file=0; given several times, all must hold. Attributes are those of --color-by but rgb, also by
    /// their short names: class, return, returns, source, time, z
    #[arg(long, value_name = "ATTRIBUTE=VALUES")]
    filter: Vec<Clause>,
    /// Show only what lies in this box, in the file's coordinates; the last number turns it around its middle
    #[arg(long, value_name = "X0,Y0,Z0,X1,Y1,Z1[,DEGREES]", allow_hyphen_values = true)]
    clip: Option<ClipBox>,
    /// Show only a section: a point of it, the direction across, and how thick it is
    #[arg(long, value_name = "X,Y,Z,NX,NY,NZ,THICKNESS", allow_hyphen_values = true)]
    slab: Option<Slab>,
}

impl FilterArgs {
    pub fn filter(&self) -> Filter {
        Filter { clauses: self.filter.clone() }
    }

    pub fn clip(&self) -> Clip {
        Clip { bounds: self.clip, slab: self.slab }
    }
}

/// The options of what points are coloured by, and how.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "How it is coloured")]
pub struct ColorArgs {
    /// auto (rgb if a file has any, else intensity, else elevation), rgb, intensity, elevation, classification,
    /// return-number, number-of-returns, last-return, point-source, user-data, scan-angle, gps-time, file, or
    /// extra:NAME, an extra-bytes dimension (extra:NAME[1] and extra:NAME[2] its other elements); also by their short
    /// names: class, return, returns, source, time, z
    #[arg(long, value_name = "WHAT", default_value = "auto", value_parser = values::named::<ColorBy>(ColorBy::names), hide_possible_values = true)]
    color_by: ColorBy,
    /// Values that have the first and the last colour, in the attribute's unit; by default from the points
    #[arg(long, value_name = "LOW,HIGH", value_parser = values::parse_range, allow_hyphen_values = true)]
    color_range: Option<[f64; 2]>,
    /// Percent of the points that the automatic range leaves out at either end, 0 to below 50
    #[arg(long, value_name = "PERCENT", default_value_t = CLIP_PERCENT, value_parser = values::parse_clip, allow_negative_numbers = true)]
    color_clip: f64,
    /// viridis, plasma, inferno, magma, cividis, turbo, spectral or grey; by default grey for intensity, else
    /// viridis
    #[arg(long, value_name = "MAP", value_parser = values::named::<ColorMap>(ColorMap::names), hide_possible_values = true)]
    color_map: Option<ColorMap>,
    /// Another colour for a class, such as 6=#ff0000; may be repeated
    #[arg(long, value_name = "CLASS=#RRGGBB", value_delimiter = ',', value_parser = values::parse_class_color)]
    class_color: Vec<(u8, [u8; 3])>,
    /// Another colour for a file, by its number from 0 in the order given, such as 1=#00ff00; may be repeated
    #[arg(long, value_name = "FILE=#RRGGBB", value_delimiter = ',', value_parser = values::parse_file_color)]
    file_color: Vec<(usize, [u8; 3])>,
    /// Added to all colours, −1 to 1
    #[arg(long, value_name = "N", default_value_t = Tone::default().brightness, value_parser = values::parse_brightness, allow_negative_numbers = true)]
    brightness: f64,
    /// Contrast of all colours around the middle, 0 to 10
    #[arg(long, value_name = "FACTOR", default_value_t = Tone::default().contrast, value_parser = values::parse_contrast, allow_negative_numbers = true)]
    contrast: f64,
    /// Above 1 lightens the dark, 0.1 to 10
    #[arg(long, value_name = "GAMMA", default_value_t = Tone::default().gamma, value_parser = values::parse_gamma, allow_negative_numbers = true)]
    gamma: f64,
}

impl ColorArgs {
    pub fn coloring(&self) -> Coloring {
        let mut coloring = Coloring {
            by: self.color_by.clone(),
            map: self.color_map,
            range: self.color_range,
            clip_percent: self.color_clip,
            files: self.file_color.iter().copied().collect(),
            tone: Tone { brightness: self.brightness, contrast: self.contrast, gamma: self.gamma },
            ..Default::default()
        };
        for &(class, color) in &self.class_color {
            coloring.classes.set_color(class, color);
        }
        coloring
    }
}

/// Which field of [`Look`] an option sets, as a JSON pointer.
pub const FIELDS: [(&str, &str); 19] = [
    ("point_size", "/point_size"),
    ("orthographic", "/projection"),
    ("fill_holes", "/shading/fill_holes"),
    ("decorate", "/decor"),
    ("edl", "/shading/edl_strength"),
    ("hq", "/shading/high_quality"),
    ("background", "/shading/background"),
    ("filter", "/filter"),
    ("clip", "/clip/bounds"),
    ("slab", "/clip/slab"),
    ("color_by", "/coloring/by"),
    ("color_range", "/coloring/range"),
    ("color_clip", "/coloring/clip_percent"),
    ("color_map", "/coloring/map"),
    ("class_color", "/coloring/classes"),
    ("file_color", "/coloring/files"),
    ("brightness", "/coloring/tone/brightness"),
    ("contrast", "/coloring/tone/contrast"),
    ("gamma", "/coloring/tone/gamma"),
];

/// The fields of a look that were given on the command line, rather than left at their defaults.
pub fn given(matches: &ArgMatches) -> Vec<&'static str> {
    let is_given = |id: &str| matches.value_source(id) == Some(ValueSource::CommandLine);
    FIELDS.into_iter().filter(|(id, _)| is_given(id)).map(|(_, field)| field).collect()
}

impl LookArgs {
    /// `point_size` is for where none is given.
    pub fn look(&self, point_size: PointSize) -> Look {
        Look {
            point_size: self.shape.point_size().unwrap_or(point_size),
            projection: self.shape.projection(),
            shading: Shading {
                edl_strength: self.edl,
                high_quality: self.hq,
                fill_holes: self.fill_holes,
                background: self.background.unwrap_or(Shading::default().background),
            },
            coloring: self.color.coloring(),
            filter: self.filter.filter(),
            clip: self.filter.clip(),
            decor: self.decorate.unwrap_or_default(),
        }
    }
}

#[cfg(test)]
mod tests {
    use clap::{Command, FromArgMatches};

    use super::*;

    #[test]
    fn every_option_says_which_field_it_sets() {
        let command = LookArgs::augment_args(Command::new("look"));
        let json = serde_json::to_value(Look::default()).unwrap();
        for argument in command.get_arguments() {
            let field = FIELDS.iter().find(|(id, _)| argument.get_id() == id);
            let (_, field) = field.unwrap_or_else(|| panic!("{} is missing in FIELDS", argument.get_id()));
            assert!(json.pointer(field).is_some(), "no {field} in {json}");
        }
        let matches = command.try_get_matches_from(["look", "--edl", "0.4", "--hq"]).unwrap();
        assert_eq!(
            given(&matches),
            ["/shading/edl_strength", "/shading/high_quality"],
            "a default may be given as well"
        );
        let look = LookArgs::from_arg_matches(&matches).unwrap().look(2.into());
        assert!(look.shading.high_quality);
    }
}
