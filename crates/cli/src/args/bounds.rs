//! The arguments of `bounds`.

use std::path::PathBuf;
use std::str::FromStr;

use clap::{Args, ValueEnum};

use super::{Format, SceneArgs, StepsArg};

/// Arguments of `bounds`.
#[derive(Debug, Args)]
pub struct BoundsArgs {
    /// What to bound.
    #[command(flatten)]
    pub scene: SceneArgs,
    /// The algorithm; without it chain, or exact where only that can do what is asked
    #[arg(long, value_enum)]
    pub method: Option<MethodArg>,
    /// The kind of volume; all but aabb are made by the exact method
    #[arg(long, value_enum, default_value_t)]
    pub volume: VolumeArg,
    /// What becomes of ∩ and \; all but algebra is of the exact method
    #[arg(long, value_enum, default_value_t)]
    pub booleans: BooleansArg,
    /// How much larger than the least one an exact volume may be, relative to its extent; without it 1e-12
    ///
    /// The radius of a sphere is by so much larger than the least one, and without it by 0.01: a thousandth already takes
    /// thousands of queries, and there are no more than some 30,000; it says how close it has come. For --booleans search it is the precision of the search, and without it 0.001.
    #[arg(long, value_name = "T", allow_hyphen_values = true, value_parser = tolerance)]
    pub tolerance: Option<f64>,
    /// List the volumes of all states of symbols, too, with their numbers; JSON always does where the method is exact
    #[arg(long)]
    pub states: bool,
    /// Run all methods and volumes, and compare what they cost with what they give
    ///
    /// --tolerance is then that of spheres and of the search.
    #[arg(long, conflicts_with_all = ["method", "volume", "booleans", "states", "plot"])]
    pub compare: bool,
    /// Draw how the box of the whole grows with the recursion, and what that costs, by all methods
    ///
    /// Times are printed and not drawn: the same file gives the same picture.
    #[arg(long, value_name = "FILE.svg", value_parser = svg_path, conflicts_with_all = ["method", "volume", "booleans", "tolerance", "states"])]
    pub plot: Option<PathBuf>,
    /// The parameter along the plot, and its first and last value
    ///
    /// Without it, the parameter that counts the recursion down, from 0 to its value. At most 64 values are tried.
    #[arg(long, value_name = "NAME=A..B", requires = "plot", allow_hyphen_values = true)]
    pub sweep: Option<Sweep>,
    /// How to limit the computation.
    #[command(flatten)]
    pub limit: StepsArg,
    /// How to print them
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
}

fn tolerance(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(tolerance) if (0.0..=1.0).contains(&tolerance) => Ok(tolerance),
        _ => Err("a tolerance is a number from 0 to 1, for example 1e-6".to_owned()),
    }
}

/// An algorithm for boxes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum MethodArg {
    /// Boxes of transformed boxes (the paper's section 2)
    Conventional,
    /// Boxes of point sets that went through the whole transform chain (section 3)
    #[default]
    Chain,
    /// The least box of every state, found without unfolding; those of a node's states joined
    Exact,
}

impl MethodArg {
    /// The name on the command line.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Conventional => "conventional",
            Self::Chain => "chain",
            Self::Exact => "exact",
        }
    }
}

pub(super) fn svg_path(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    let is_svg = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("svg"));
    if is_svg { Ok(path) } else { Err("plots are SVG files: end the name with .svg".to_owned()) }
}

/// A kind of volume.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum VolumeArg {
    /// Axis-aligned box
    #[default]
    Aabb,
    /// Sphere
    Sphere,
    /// Slabs between 6 planes: a box again
    Slab6,
    /// Between 14 planes, across the axes and the diagonals of the cube; also `slab`
    #[value(alias = "slab")]
    Slab14,
    /// Between 18 planes, across the axes and the diagonals of the cube's faces
    Slab18,
    /// Between 26 planes: all of these
    Slab26,
    /// Oriented box
    Obb,
}

impl VolumeArg {
    /// The name on the command line.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Aabb => "aabb",
            Self::Sphere => "sphere",
            Self::Slab6 => "slab6",
            Self::Slab14 => "slab14",
            Self::Slab18 => "slab18",
            Self::Slab26 => "slab26",
            Self::Obb => "obb",
        }
    }
}

/// How ∩ and \ are bounded.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum BooleansArg {
    /// By their operands: ∩ by what both boxes have in common, \ by the box of the left one
    #[default]
    Algebra,
    /// By S-bounds: of each node not its own box but what of it can matter to the whole
    Context,
    /// By branch and bound: the whole to a tolerance; nodes and states as by algebra
    Search,
}

impl BooleansArg {
    /// The name on the command line.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Algebra => "algebra",
            Self::Context => "context",
            Self::Search => "search",
        }
    }
}

/// A parameter, and the whole numbers that it takes one after the other.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Sweep {
    /// The parameter.
    pub name: String,
    /// Its first value.
    pub first: i32,
    /// Its last value, larger than the first.
    pub last: i32,
}

impl Sweep {
    /// All values, or as many as are tried at most, evenly spread from the first to the last.
    pub(crate) fn values(&self, most: u16) -> Vec<i32> {
        let (first, length) = (i64::from(self.first), i64::from(self.last) - i64::from(self.first));
        let steps = length.min(i64::from(most) - 1);
        let value = |step: i64| first + length * step / steps;
        (0..=steps)
            .map(|step| i32::try_from(value(step)).expect("it is between the first and the last"))
            .collect()
    }
}

impl FromStr for Sweep {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parse = || {
            let (name, range) = text.split_once('=')?;
            let (first, last) = range.split_once("..")?;
            let name = name.trim();
            let (first, last) = (first.trim().parse().ok()?, last.trim().parse().ok()?);
            (!name.is_empty()).then(|| Self { name: name.to_owned(), first, last })
        };
        let sweep: Self = parse().ok_or("write it as NAME=A..B with whole numbers, for example cnt=0..12")?;
        if sweep.first < sweep.last {
            Ok(sweep)
        } else {
            Err("the last value must be above the first".to_owned())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sweep_tries_every_value_or_64_of_them() {
        let sweep = |first, last| Sweep { name: "n".to_owned(), first, last };
        assert_eq!(sweep(-1, 3).values(64), [-1, 0, 1, 2, 3]);
        for (first, last) in [(0, 63), (0, 64), (-5, 1_000_000), (i32::MIN, i32::MAX)] {
            let values = sweep(first, last).values(64);
            assert_eq!((values.len(), values[0], values[63]), (64, first, last));
            assert!(values.windows(2).all(|pair| pair[0] < pair[1]));
        }
    }
}
