//! The command line that gives a picture: what a window shows, for a script or a colleague.

use std::path::PathBuf;

use crate::render::{Camera, ClassTable, Clip, Coloring, Decor, Filter, Look, Projection, Shading, Tone};

/// `firstlight render …` for what this camera shows, quoted for a POSIX shell. Options that have their default value are
/// left out. Names that are no UTF-8 do not survive.
pub fn command(look: &Look, camera: &Camera, size: [u32; 2], inputs: &[PathBuf]) -> String {
    let mut words = vec!["firstlight".to_owned(), "render".to_owned()];
    words.extend(inputs.iter().map(|input| input_word(input)));
    words.extend(["-o".into(), "picture.png".into()]);
    option(&mut words, "--size", format!("{}x{}", size[0], size[1]));
    let camera = serde_json::to_string(camera).expect("a camera is numbers and names");
    option(&mut words, "--camera", camera);
    look_words(look, &mut words);
    words.iter().map(|word| quoted(word)).collect::<Vec<_>>().join(" ")
}

/// Every option of `cli::look` that is not at its default. A new field of `Look` does not compile until it is here.
fn look_words(look: &Look, words: &mut Vec<String>) {
    let Look { point_size, projection, shading, coloring, filter, clip, decor } = look;
    let Shading { edl_strength, background, high_quality, fill_holes } = shading;
    let Filter { clauses } = filter;
    let Clip { bounds, slab } = clip;
    let usual = Look::default();
    if *point_size != usual.point_size {
        option(words, "--point-size", point_size.to_string());
    }
    if *projection == Projection::Orthographic {
        words.push("--orthographic".into());
    }
    if *edl_strength != usual.shading.edl_strength {
        option(words, "--edl", edl_strength.to_string());
    }
    if *high_quality {
        words.push("--hq".into());
    }
    if *fill_holes {
        words.push("--fill-holes".into());
    }
    // Colours that have no legend need no word for it.
    let decor = Decor { legend: decor.legend && coloring.by.attribute().is_some(), ..*decor };
    if !decor.is_empty() {
        option(words, "--decorate", decor.to_string());
    }
    if *background != usual.shading.background {
        let [red, green, blue] = background;
        option(words, "--background", format!("#{red:02x}{green:02x}{blue:02x}"));
    }
    color_words(coloring, words);
    for clause in clauses {
        option(words, "--filter", clause.to_string());
    }
    if let Some(bounds) = bounds {
        option(words, "--clip", bounds.to_string());
    }
    if let Some(slab) = slab {
        option(words, "--slab", slab.to_string());
    }
}

/// The same of `cli::look::ColorArgs`. Names of classes are not in a picture.
fn color_words(coloring: &Coloring, words: &mut Vec<String>) {
    let Coloring { by, map, range, clip_percent, classes, files, tone } = coloring;
    let Tone { brightness, contrast, gamma } = tone;
    let usual = Coloring::default();
    if *by != usual.by {
        option(words, "--color-by", by.to_string());
    }
    if let Some(map) = map {
        option(words, "--color-map", map.to_string());
    }
    if let Some([low, high]) = range {
        option(words, "--color-range", format!("{low},{high}"));
    }
    if *clip_percent != usual.clip_percent {
        option(words, "--color-clip", clip_percent.to_string());
    }
    for (number, class) in classes.changed() {
        let [red, green, blue] = class.color;
        if class.color != ClassTable::default().color(number) {
            option(words, "--class-color", format!("{number}=#{red:02x}{green:02x}{blue:02x}"));
        }
    }
    for (number, [red, green, blue]) in files {
        option(words, "--file-color", format!("{number}=#{red:02x}{green:02x}{blue:02x}"));
    }
    let tones = [
        ("--brightness", *brightness, usual.tone.brightness),
        ("--contrast", *contrast, usual.tone.contrast),
        ("--gamma", *gamma, usual.tone.gamma),
    ];
    for (name, value, _) in tones.into_iter().filter(|(_, value, usual)| value != usual) {
        option(words, name, value.to_string());
    }
}

/// A value that begins with a hyphen would be taken for an option.
fn option(words: &mut Vec<String>, name: &str, value: String) {
    if value.starts_with('-') {
        words.push(format!("{name}={value}"));
    } else {
        words.extend([name.into(), value]);
    }
}

fn input_word(input: &std::path::Path) -> String {
    let name = input.to_string_lossy();
    if name.starts_with('-') { format!("./{name}") } else { name.into() }
}

/// A word as a POSIX shell takes it whole.
fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "_@%+=:,./-".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        return word.into();
    }
    format!("'{}'", word.replace('\'', r"'\''"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_survive_a_shell() {
        for (word, text) in [
            ("scan.laz", "scan.laz"),
            ("", "''"),
            ("my scan.laz", "'my scan.laz'"),
            ("it's", r"'it'\''s'"),
            ("$HOME/*", "'$HOME/*'"),
            ("größe.laz", "'größe.laz'"),
        ] {
            assert_eq!(quoted(word), text);
        }
        assert_eq!(input_word(std::path::Path::new("-o.laz")), "./-o.laz");
    }
}
