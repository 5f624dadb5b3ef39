//! The kinds of volumes: how each is made about a solid, and how it is written down.

use csg_graph_bounds::{Aabb, CertifiedSphere, Obb, Slabs, Sphere, Volume};
use glam::DVec3;
use serde::Serialize;
use serde_json::{Value, json};

/// A volume that can be made and shown.
pub(crate) trait Shown: Volume {
    /// The name of many in sentences.
    fn kind() -> String;

    /// The directions of its planes, where they are fixed.
    const DIRECTIONS: &'static [DVec3] = &[];

    /// A volume about a solid whose box is known.
    fn about(_known: Aabb, _tolerance: Option<f64>, support: impl FnMut(DVec3) -> f64) -> Self {
        Self::from_support(support)
    }

    /// The same, and how much larger than the least one it is at most, where it is not the least one up to the supports.
    fn certified(
        known: Aabb,
        tolerance: Option<f64>,
        support: impl FnMut(DVec3) -> f64,
    ) -> (Self, Option<f64>) {
        (Self::about(known, tolerance, support), None)
    }

    /// Its numbers, for programs.
    fn numbers(&self) -> Value;

    /// For people, in a line: what there is to say besides its size.
    fn line(&self) -> String;
}

impl Shown for Aabb {
    fn kind() -> String {
        "boxes".to_owned()
    }

    fn about(known: Aabb, _: Option<f64>, _: impl FnMut(DVec3) -> f64) -> Self {
        known
    }

    fn numbers(&self) -> Value {
        json!({ "min": self.min.to_array(), "max": self.max.to_array() })
    }

    fn line(&self) -> String {
        format!("{} .. {}", point(self.min), point(self.max))
    }
}

impl Shown for Sphere {
    fn kind() -> String {
        "spheres".to_owned()
    }

    fn about(known: Aabb, tolerance: Option<f64>, support: impl FnMut(DVec3) -> f64) -> Self {
        Self::certified(known, tolerance, support).0
    }

    fn certified(_: Aabb, tolerance: Option<f64>, support: impl FnMut(DVec3) -> f64) -> (Self, Option<f64>) {
        let CertifiedSphere { sphere, at_least, .. } =
            CertifiedSphere::from_support(support, tolerance.unwrap_or(Self::TOLERANCE));
        let excess = sphere.radius / at_least - 1.0;
        (sphere, Some(excess).filter(|excess| excess.is_finite()))
    }

    fn numbers(&self) -> Value {
        json!({ "center": self.center.to_array(), "radius": self.radius })
    }

    fn line(&self) -> String {
        format!("{} radius {:.4}", point(self.center), self.radius)
    }
}

impl<const N: usize> Shown for Slabs<N> {
    const DIRECTIONS: &'static [DVec3] = &Self::DIRECTIONS;

    fn kind() -> String {
        format!("slabs of {} planes", 2 * N)
    }

    fn numbers(&self) -> Value {
        json!({ "min": self.min[..], "max": self.max[..] })
    }

    /// Of all planes only those across the axes fit into a line.
    fn line(&self) -> String {
        format!("in {}", self.aabb().line())
    }
}

impl Shown for Obb {
    fn kind() -> String {
        "oriented boxes".to_owned()
    }

    /// Its points p are those with `min[i]` ≤ `axes[i]`·p ≤ `max[i]`. The centre and the half sizes, which are easier to
    /// use, are rounded from these.
    fn numbers(&self) -> Value {
        let frame = self.world_from_box();
        let Aabb { min, max } = self.bounds();
        json!({
            "axes": frame.to_cols_array_2d(),
            "min": min.to_array(),
            "max": max.to_array(),
            "center": (frame * self.bounds().center()).to_array(),
            "half_sizes": (self.bounds().size() * 0.5).to_array(),
        })
    }

    fn line(&self) -> String {
        let [x, y, z] = self.bounds().size().to_array().map(number);
        format!("{} {x} × {y} × {z}", point(self.world_from_box() * self.bounds().center()))
    }
}

/// A volume in a report: its numbers and its size.
#[derive(Serialize)]
pub(super) struct Entry {
    #[serde(flatten)]
    numbers: Value,
    volume: f64,
    surface_area: f64,
}

impl Entry {
    pub(super) fn new(shown: &impl Shown) -> Self {
        Self { numbers: shown.numbers(), volume: shown.volume(), surface_area: shown.surface_area() }
    }
}

/// A volume for people.
pub(crate) fn line(shown: &impl Shown) -> String {
    if shown.is_empty() { "empty".to_owned() } else { shown.line() }
}

/// A point for people.
pub(crate) fn point(p: DVec3) -> String {
    let [x, y, z] = p.to_array().map(|c| format!("{:>9}", number(c)));
    format!("[{x}, {y}, {z}]")
}

/// Four places, without the sign that rounding may leave at zero. Of what is large, the first digits.
fn number(c: f64) -> String {
    match c.abs() {
        ..5e-5 => "0.0000".to_owned(),
        1e9.. => format!("{c:.4e}"),
        _ => format!("{c:.4}"),
    }
}
