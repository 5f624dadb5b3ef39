//! Glass that stands on something.
//!
//! Where a face of glass coincides with one of something opaque, it is a matter of rounding which of the two a ray in the
//! glass meets first. If it is that of the glass, the ray would go on inside of what is opaque, or be reflected where there
//! is nothing to reflect it. So it is looked behind each face by which a ray leaves glass: what it gets outside of there
//! without having come inside has been in touch with the glass, and is met in its place.

use csg_graph::EvalError;

use super::Place;
use crate::engine::Tracer;
use crate::{Hit, Ray};

/// Looks behind faces of glass.
#[derive(Debug, Default)]
pub(super) struct Contacts {
    lanes: Vec<usize>,
    rays: Vec<Ray>,
    behind: Vec<Option<Hit>>,
}

impl Contacts {
    /// Replaces hits of rays that leave glass by what is in touch with it.
    pub(super) fn replace(
        &mut self,
        tracer: &mut Tracer<'_>,
        rays: &[Ray],
        hits: &mut [Option<Hit>],
    ) -> Result<(), EvalError> {
        self.lanes.clear();
        self.rays.clear();
        for (lane, (ray, hit)) in rays.iter().zip(&*hits).enumerate() {
            if let Some(hit) = hit.as_ref().filter(|hit| hit.surface.glass > 0.0 && is_left(ray, hit)) {
                self.lanes.push(lane);
                self.rays.push(Ray { origin: Place::new(ray, hit).behind(), direction: ray.direction });
            }
        }
        if self.rays.is_empty() {
            return Ok(());
        }
        tracer.nearest(self.rays.as_slice().into(), &mut self.behind)?;
        for ((lane, ray), behind) in self.lanes.iter().zip(&self.rays).zip(&self.behind) {
            let opaque = behind.filter(|behind| behind.surface.glass == 0.0 && is_left(ray, behind));
            if let (Some(hit), Some(Hit { surface, node, depth, .. })) = (&mut hits[*lane], opaque) {
                *hit = Hit { normal: -hit.normal, surface, node, depth, ..*hit };
            }
        }
        Ok(())
    }
}

/// Whether a ray gets outside by the face that it hits.
fn is_left(ray: &Ray, hit: &Hit) -> bool {
    hit.normal.dot(ray.direction) > 0.0
}
