//! What a frame of each method consists of: clear, geometry passes, resolve.

use super::modules::{self, Kernel};

/// The picture of a method as the twins define it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rule {
    /// The nearest point; of equally near ones the first.
    Nearest,
    /// As `Nearest`, by the depth that a depth buffer has.
    NearestNormalized,
    /// Any point of the pixel.
    Any,
    /// Any point of the pixel, with the depth of any.
    AnyTorn,
    /// The smallest word of 40-bit depth and colour.
    Depth40 { is_ranged: bool },
    /// The average of all within 1 % of the front; the sums overflow as told.
    Average(Sums),
}

/// How an average is summed up.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sums {
    /// 32 bits for each of four sums.
    Bits32,
    /// 18 bits for each colour, 10 for the count.
    Bits18,
}

/// One geometry pass, or a look at the result for a read-back.
#[derive(Debug)]
pub enum Step {
    /// A kernel that has a thread for each point.
    Points(&'static Kernel),
    /// Hardware points.
    Draw,
}

/// What happens after the geometry passes.
#[derive(Debug)]
pub enum Resolve {
    /// Colours of the points that the words name.
    Points,
    /// As `Points`, after the hardware's textures were turned into words.
    Textures,
    /// An entry point of resolve.wgsl that looks at targets alone.
    Targets(&'static Kernel),
}

/// How a read-back finds the point and the depth of each pixel.
#[derive(Debug)]
pub enum Identify {
    /// Both are in the word.
    Word,
    /// The point is; its depth is computed anew.
    Depth,
    /// The depth is: a pass as of two-pass-32 finds its first point.
    FrontPoint,
    /// A pass with this kernel finds the first point that has the pixel's word.
    WordPoint(&'static Kernel),
}

/// A method in passes.
#[derive(Debug)]
pub struct Plan {
    pub rule: Rule,
    pub geometry: &'static [Step],
    /// Whether it uses more than words.
    pub has_sums: bool,
    pub resolve: Resolve,
    pub identify: Identify,
}

/// One plan for each row of the table.
pub mod plans {
    use super::{
        Identify, Plan, Resolve, Rule,
        Step::{Draw, Points},
        Sums, modules,
    };

    const fn words(rule: Rule, geometry: &'static [super::Step], identify: Identify) -> Plan {
        Plan { rule, geometry, has_sums: false, resolve: Resolve::Points, identify }
    }

    const fn depth40(is_ranged: bool, geometry: &'static [super::Step], identify: &'static modules::Kernel) -> Plan {
        Plan {
            rule: Rule::Depth40 { is_ranged },
            geometry,
            has_sums: false,
            resolve: Resolve::Targets(&modules::WORD_COLOR),
            identify: Identify::WordPoint(identify),
        }
    }

    const fn average(sums: Sums, geometry: &'static [super::Step], resolve: &'static modules::Kernel) -> Plan {
        Plan {
            rule: Rule::Average(sums),
            geometry,
            has_sums: true,
            resolve: Resolve::Targets(resolve),
            identify: Identify::FrontPoint,
        }
    }

    pub static POINTS: Plan = Plan {
        rule: Rule::Nearest,
        geometry: &[Draw],
        has_sums: false,
        resolve: Resolve::Textures,
        identify: Identify::Word,
    };
    pub static JUST_SET: Plan = words(Rule::Any, &[Points(&modules::JUST_SET)], Identify::Depth);
    pub static ATOMIC_MIN: Plan = words(Rule::Nearest, &[Points(&modules::ATOMIC_MIN)], Identify::Word);
    pub static EARLY_Z: Plan = words(Rule::Nearest, &[Points(&modules::EARLY_Z)], Identify::Word);
    pub static REDUCE: Plan = words(Rule::Nearest, &[Points(&modules::REDUCE)], Identify::Word);
    pub static REDUCE_EARLY_Z: Plan = words(Rule::Nearest, &[Points(&modules::REDUCE_EARLY_Z)], Identify::Word);
    pub static DEDUP: Plan = words(Rule::Nearest, &[Points(&modules::DEDUP)], Identify::Word);
    pub static BUSY_LOOP: Plan =
        Plan { has_sums: true, ..words(Rule::Nearest, &[Points(&modules::BUSY_LOOP)], Identify::Word) };
    pub static BUSY_LOOP_N: Plan =
        Plan { has_sums: true, ..words(Rule::NearestNormalized, &[Points(&modules::BUSY_LOOP_N)], Identify::Depth) };
    pub static RACY: Plan = words(Rule::AnyTorn, &[Points(&modules::RACY)], Identify::Word);
    pub static TWO_PASS_32: Plan =
        words(Rule::Nearest, &[Points(&modules::DEPTH_32), Points(&modules::SLOT_32)], Identify::Word);
    pub static DEPTH40: Plan = depth40(false, &[Points(&modules::DEPTH40)], &modules::IDENTIFY_DEPTH40);
    pub static DEPTH40_RANGES: Plan =
        depth40(true, &[Points(&modules::DEPTH40_RANGES)], &modules::IDENTIFY_DEPTH40_RANGES);
    pub static HQS: Plan =
        average(Sums::Bits32, &[Points(&modules::DEPTH_32), Points(&modules::HQS)], &modules::AVERAGE_SUMS);
    pub static HQS_64: Plan =
        average(Sums::Bits32, &[Points(&modules::DEPTH_32), Points(&modules::HQS_64)], &modules::AVERAGE_SUMS);
    pub static HQS1: Plan =
        average(Sums::Bits18, &[Points(&modules::DEPTH_32), Points(&modules::HQS1)], &modules::AVERAGE_18_BITS);
    pub static HQS1R: Plan =
        average(Sums::Bits32, &[Points(&modules::DEPTH_32), Points(&modules::HQS1R)], &modules::AVERAGE_16_BITS);
}
