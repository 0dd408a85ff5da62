//! The examples of each command's help. A test parses every one of them.

use super::exit;

pub const OPEN: &str = "\
Examples:
  firstlight scan.laz
  firstlight north.laz south.laz scans/
  firstlight scan.laz --edl 1 --hq --filter class=2,6
  firstlight render scan.laz -o scan.png";

pub const RENDER: &str = "\
Examples:
  firstlight render scan.laz -o scan.png
  firstlight render scans/ -o all.png --size 3840x2160 --hq
  firstlight render scan.laz -o ground.png --filter class=2,9 --filter return=1
  firstlight render scan.laz -o trees.png --filter 'class!=2,6,7,18' --filter elevation=210..255.5
  firstlight render strips/ -o second.png --filter file=1 --filter gps-time=315964800.5..315964900
  firstlight render scan.laz -o house.png --clip 456000,5412000,200,456040,5412025,230,30
  firstlight render scan.laz -o section.png --slab 456020,5412010,0,1,0,0,0.5
  firstlight render scan.laz -o - --stop points=1M | display
  firstlight render scan.laz --ids ids.npy --depth depth.npy --camera '{\"eye\":[0,-50,20],\"target\":[0,0,0]}'";

pub const INFO: &str = "\
Examples:
  firstlight info scan.laz
  firstlight info scans/ --json | jq '.[].points.count'";

pub const POINT: &str = "\
Examples:
  firstlight point scan.laz 0
  firstlight point scan.laz 0 1200..1205 --csv > points.csv
  firstlight point scan.laz 1200 --json | jq .gps_time";

pub const PICK: &str = "\
Examples:
  firstlight pick scan.laz --at 800,450
  firstlight pick scan.laz --camera cam.json --size 800x600 --at 10,20 --at 400,300 --reach 0 --csv
  firstlight pick north.laz south.laz --at 800,450 --json | jq .gps_time";

pub const SYNTH: &str = "\
Examples:
  firstlight synth town -o town.laz --points 10M
  firstlight synth planes -o planes.las -n 100k --point-format 3 --las-version 1.2";

pub const BENCH: &str = "\
Examples:
  firstlight bench --synth town:1M -o report
  firstlight bench scan.laz -o report --size 1920x1080";

pub const MEASURE: &str = "\
Examples:
  firstlight measure scan.laz -o report
  firstlight measure --synth town:1M -o report --clock virtual --motion orbit";

pub const STABILITY: &str = "\
Examples:
  firstlight stability --list
  firstlight stability -o report";

pub const BENCH_FRAMES: &str = "\
Examples:
  firstlight bench-frames scan.laz
  firstlight bench-frames --synth town:16M --at 1M,4M,16M --size 1280x720";

pub const BENCH_INGEST: &str = "\
Examples:
  firstlight bench-ingest scan.laz -o report";

pub const COMPLETIONS: &str = "\
Examples:
  firstlight completions bash > ~/.local/share/bash-completion/completions/firstlight
  firstlight completions zsh > ~/.zfunc/_firstlight
  firstlight completions fish > ~/.config/fish/completions/firstlight.fish";

pub const MAN: &str = "\
Examples:
  firstlight man | man -l -
  firstlight man ~/.local/share/man/man1";

/// Examples before what else the help says.
pub fn before(examples: &str, help: &str) -> String {
    format!("{examples}\n\n{help}")
}

/// Examples before the exit codes of most commands.
pub fn before_codes(examples: &str) -> String {
    before(examples, exit::HELP)
}
