//! The arguments that choose the engine, which `render` and `bench` share.

use std::fmt;

use clap::{Args, ValueEnum};
use csg_graph_trace::{Accelerated, Grid};

use super::values::{bytes, pixels, whole};
use super::{MethodArg, StepsArg, ViewArg};
use crate::Failure;

/// The `--memory` of whoever does not say, and as it is written.
pub(crate) const USUAL_MEMORY: (usize, &str) = (1 << 30, "1G");

/// What finds where rays meet the solid.
#[derive(Debug, Args)]
pub struct EngineArgs {
    /// What finds where rays meet the solid; without it fast, or reference where only that can do what is asked
    ///
    /// The pictures are the same, the time is not. The views plate and cost show the boxes of the paper, which the
    /// reference walk alone has; --boxes and --max-steps are about them too.
    #[arg(long, value_enum)]
    pub engine: Option<EngineArg>,
    /// Memory for the fast engine or the grid: bytes, or with a suffix K, M or G of 1024 each; without it 384K for the fast
    /// engine and 16M for the grid
    ///
    /// More memory is more speed, up to a point. The fast engine takes more than this only where the states alone need
    /// more.
    #[arg(long, value_name = "BYTES", allow_hyphen_values = true, value_parser = bytes)]
    pub budget: Option<usize>,
    /// Do not look into parts that cover less than so many pixels; without it 1 where the states do not fit into memory,
    /// 0.5 where the recursion never ends, and else 0
    ///
    /// What stands for such a part is its box, which shows the paint of something in it; silhouettes are off by no more
    /// than that. Mostly the box stops only as many rays as what is in it would. With 0 everything is looked into. For
    /// the fast engine.
    #[arg(long, value_name = "PIXELS", allow_hyphen_values = true, value_parser = pixels)]
    pub detail: Option<f64>,
    /// Memory for the picture and what is remembered of the scene: bytes, or with a suffix K, M or G of 1024 each
    ///
    /// States are listed if they fit into it at 1K each. Otherwise parts of the scene are made when rays come to them, with
    /// another default of --detail; with less memory, they are made again more often, and the picture is the same. Some
    /// megabytes for each thread are needed in any case.
    #[arg(long, value_name = "BYTES", allow_hyphen_values = true, default_value = USUAL_MEMORY.1, value_parser = bytes)]
    pub memory: usize,
    /// Voxels along the longest side of the grid; without it as many as suit the number of primitives
    ///
    /// There are fewer where they would take more than half of the budget.
    #[arg(long, value_name = "N", allow_hyphen_values = true, value_parser = whole::<u32>(1..=u32::MAX.into()))]
    pub resolution: Option<u32>,
    /// Which boxes the reference walk tests rays against; without it chain, or exact where chain would take more than a
    /// moment
    ///
    /// Pictures of the solid are the same for all, the time is not; the views plate and cost show what the boxes do.
    #[arg(long, value_enum)]
    pub boxes: Option<BoxesArg>,
    /// How to limit the computation of boxes.
    #[command(flatten)]
    pub limit: StepsArg,
}

/// An engine.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum EngineArg {
    /// The paper's walk: nodes evaluated for each ray, a box tested at every node
    Reference,
    /// States compiled beforehand into wide trees of boxes, rays traced in packets
    Fast,
    /// The paper's grid: its walk, but rays enter the graph at the states that the voxels on their way hold
    Grid,
}

/// Which boxes a render uses.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum BoxesArg {
    /// No boxes: every ray visits every node
    None,
    /// Boxes of transformed boxes (the paper's section 2)
    Conventional,
    /// Boxes of point sets that went through the whole transform chain (section 3)
    Chain,
    /// The least boxes of all states, joined
    Exact,
}

/// The engine that is to be made ready, and with what.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Plan {
    Reference {
        /// The boxes that were asked for, if any were.
        boxes: Option<BoxesArg>,
        max_steps: u64,
    },
    Fast {
        budget: usize,
        /// Pixels that parts must cover to be looked into.
        detail: Option<f64>,
        memory: usize,
    },
    Grid {
        resolution: Option<u32>,
        budget: usize,
    },
}

impl Plan {
    /// What the program takes besides an engine and a picture, in bytes.
    const PROGRAM: usize = 8 << 20;

    /// The same where a picture of so many bytes is to fit into the memory as well.
    pub(crate) fn beside_picture(self, bytes: usize) -> Self {
        let Self::Fast { budget, detail, memory } = self else { return self };
        let besides = bytes.saturating_add(Self::PROGRAM);
        Self::Fast { budget, detail, memory: memory.saturating_sub(besides) }
    }
}

impl EngineArgs {
    /// The engine that can do what is asked.
    ///
    /// # Errors
    /// If the arguments contradict each other.
    pub(crate) fn plan(&self, view: ViewArg) -> Result<Plan, Failure> {
        let of_reference = match view {
            _ if self.boxes.is_some() => Some("--boxes"),
            _ if self.limit.max_steps.is_some() => Some("--max-steps"),
            ViewArg::Plate => Some("--view plate"),
            ViewArg::Cost => Some("--view cost"),
            ViewArg::Shaded | ViewArg::Normal | ViewArg::Depth => None,
        };
        let engine = match (self.engine, of_reference) {
            (Some(engine @ (EngineArg::Fast | EngineArg::Grid)), Some(asked)) => {
                return Err(Failure::Usage(format!(
                    "{asked} is about the boxes of the reference walk, which --engine {engine} does not use; leave one of the two out"
                )));
            }
            (Some(engine), _) => engine,
            (None, None) => EngineArg::Fast,
            (None, Some(_)) => EngineArg::Reference,
        };
        if self.resolution.is_some() && engine != EngineArg::Grid {
            return Err(Failure::Usage(
                "--resolution is about voxels, which only --engine grid has".to_owned(),
            ));
        }
        if self.detail.is_some() && engine != EngineArg::Fast {
            let asked = of_reference.map_or_else(|| format!("--engine {engine}"), str::to_owned);
            return Err(Failure::Usage(format!(
                "--detail is about what the fast engine does not look into, and {asked} asks for another; leave one of the two out"
            )));
        }
        match engine {
            EngineArg::Reference if self.budget.is_some() => {
                let asked = of_reference.unwrap_or("--engine reference");
                Err(Failure::Usage(format!(
                    "--budget is memory for the fast engine or the grid, and {asked} asks for the reference walk; leave one of the two out"
                )))
            }
            EngineArg::Reference => Ok(Plan::Reference { boxes: self.boxes, max_steps: self.limit.once() }),
            EngineArg::Fast => Ok(Plan::Fast {
                budget: self.budget.unwrap_or(Accelerated::DEFAULT_BUDGET),
                detail: self.detail,
                memory: self.memory,
            }),
            EngineArg::Grid => Ok(Plan::Grid {
                resolution: self.resolution,
                budget: self.budget.unwrap_or(Grid::DEFAULT_BUDGET),
            }),
        }
    }
}

impl BoxesArg {
    /// The algorithm that computes them.
    pub(crate) fn method(self) -> Option<MethodArg> {
        match self {
            Self::None => None,
            Self::Conventional => Some(MethodArg::Conventional),
            Self::Chain => Some(MethodArg::Chain),
            Self::Exact => Some(MethodArg::Exact),
        }
    }
}

impl fmt::Display for EngineArg {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Reference => "reference",
            Self::Fast => "fast",
            Self::Grid => "grid",
        })
    }
}
