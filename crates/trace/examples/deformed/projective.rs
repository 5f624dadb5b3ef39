//! The taper that keeps rays straight.
//!
//! Maps that keep all lines straight are the projective ones, and one of them is a taper: it scales x and y by 1 + k z as
//! that of [BARR84] does, and moves points along the axis besides. Below it a ray is a ray, of a parameter u of its own:
//!
//! > t = start + u w / (w − u v)
//!
//! where w is the denominator at the start of the ray and v its derivative. Supports are found as in [DINK67]: the image
//! reaches no further than λ in direction d if N(p) − λ w(p) ≤ 0 for all points p of the solid, and that is one support of
//! the solid.

use csg_graph_bounds::Aabb;
use csg_graph_trace::Ray;
use glam::DVec3;

use crate::column::Column;

/// A ray below the taper.
pub(crate) struct Straight {
    /// From u = 0 on.
    pub(crate) ray: Ray,
    /// Where u ends.
    pub(crate) end: f64,
    start: f64,
    denominator: [f64; 2],
}

impl Straight {
    /// What a ray is below a taper by 1 + k z, between the heights of the column.
    pub(crate) fn new(k: f64, ray: &Ray) -> Option<Self> {
        let [a, b] = [0.0, 1.0].map(|z| (z - ray.origin.z) / ray.direction.z);
        let (start, end) = (a.min(b), a.max(b));
        let (p, d) = (ray.at(start), ray.direction);
        let (w, v) = (1.0 + k * p.z, k * d.z);
        let origin = DVec3::new(p.x, p.y, (1.0 + k) * p.z) / w;
        let direction = (DVec3::new(d.x, d.y, (1.0 + k) * d.z) - origin * v) / w;
        let end = (end - start) * w / (w + (end - start) * v);
        (end > 0.0).then_some(Self { ray: Ray { origin, direction }, end, start, denominator: [w, v] })
    }

    /// The parameter of the ray above.
    pub(crate) fn t(&self, u: f64) -> f64 {
        let [w, v] = self.denominator;
        self.start + u * w / (w - u * v)
    }
}

/// The box of a scene in the column that is then tapered, to 10⁻⁹; and how many supports of the scene it took. Every face is
/// outside, however early the search ends.
pub(crate) fn tapered_box(k: f64, column: &Column) -> (Aabb, u32) {
    let root = column.graph.root_state();
    let slope = -k / (1.0 + k);
    let mut queries = 0;
    let mut reach = |d: DVec3| {
        // The largest N(p) − λ w(p), convex and falling in λ: where it is 0, λ is the support.
        let mut excess = |lambda: f64| {
            queries += 1;
            let direction = DVec3::new(d.x, d.y, d.z / (1.0 + k) - lambda * slope);
            let support =
                column.boxes.support(&root, direction).map_or(f64::INFINITY, |support| support.upper);
            (support - direction.dot(column.foot)) / column.scale - lambda
        };
        let [least, most] = [1.0_f64.min(1.0 + slope), 1.0_f64.max(1.0 + slope)];
        let (mut high, mut low): (f64, f64) = (2.0, -2.0);
        let mut at_high = excess(high);
        loop {
            // Some point has the excess itself, and none has more; w is between `least` and `most`. The chord of a convex
            // function crosses 0 above it.
            low = low.max(high + at_high / least);
            let bound = high + at_high / most;
            if bound - low < 1e-9 {
                return bound;
            }
            let at_low = excess(low).max(0.0);
            high = bound.min(low + at_low * (high - low) / (at_low - at_high));
            at_high = excess(high).min(0.0);
        }
    };
    let [max, min] = [1.0, -1.0].map(|side| DVec3::from(DVec3::AXES.map(|axis| side * reach(side * axis))));
    (Aabb::new(min, max), queries)
}
