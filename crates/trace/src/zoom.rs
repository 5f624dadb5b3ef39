//! Going closer to what is small.

use crate::{Camera, Ray, RenderError, World, probe};

/// Rays that look for the smallest part: so many along the longer side of the picture.
const LOOK: u32 = 256;

/// How much closer it is gone at once to what has no last part.
const STEP: f64 = 16.0;

/// The camera of a world, `factor` times as close to the smallest part that it sees in a picture of that aspect, its width by
/// its height: what it meets after the deepest recursion, of several the nearest one. That comes to the middle of the
/// picture, seen along the ray that found it, so that nothing can be in the way. A camera that sees nothing stays where it is.
///
/// ```
/// use csg_graph::{GraphBuilder, PrimitiveKind};
/// use csg_graph_trace::{Camera, Engine, World, zoom};
/// use glam::DVec3;
///
/// let mut builder = GraphBuilder::new();
/// let ball = builder.primitive(PrimitiveKind::Sphere, []);
/// let graph = builder.finish(ball)?;
/// let camera = Camera { eye: DVec3::new(0.0, -11.0, 0.0), target: DVec3::ZERO, up: DVec3::Z, fov: 40.0 };
/// let background = World::DEFAULT_BACKGROUND;
/// let world = World { engine: Engine::Reference(&graph, None), camera, lights: vec![], background };
///
/// let closer = zoom(&world, 1.0, 10.0)?;
/// assert!(closer.target.distance(DVec3::new(0.0, -1.0, 0.0)) < 0.1);
/// assert!((closer.eye.distance(closer.target) - 1.0).abs() < 1e-3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// As [`probe`](crate::probe).
///
/// # Panics
/// If the boxes are of another graph, the factor is not a number from 1 on, or the aspect is not positive and finite.
pub fn zoom(world: &World<'_>, aspect: f64, factor: f64) -> Result<Camera, RenderError> {
    assert!(factor >= 1.0 && factor.is_finite(), "{factor} times as close is not closer");
    assert!(aspect > 0.0 && aspect.is_finite(), "{aspect} times as wide as high is no picture");
    let (mut world, mut left) = (world.clone(), factor);
    while let Some((ray, seen)) = smallest(&world, aspect)? {
        let mut hits = Vec::new();
        world.engine.tracer().nearest((&[ray]).into(), &mut hits)?;
        // Where recursion never ends, a line may meet nothing: then it is gone closer to what is seen in its place, step
        // by step.
        let (point, step) = match &hits[0] {
            Some(hit) => (hit.point, left),
            None => (ray.at(seen), left.min(STEP)),
        };
        let eye = point + (world.camera.eye - point) / step;
        world.camera = Camera { eye, target: point, ..world.camera };
        left /= step;
        if left <= 1.0 {
            break;
        }
    }
    Ok(world.camera)
}

/// The ray to the smallest part that a world sees, and where it is seen.
fn smallest(world: &World<'_>, aspect: f64) -> Result<Option<(Ray, f64)>, RenderError> {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "from 1 to LOOK")]
    let [width, height] =
        [aspect, 1.0 / aspect].map(|side| (f64::from(LOOK) * side.min(1.0)).round().max(1.0) as u32);
    let probes = probe(world, width, height)?;
    let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let smallest = pixels
        .zip(&probes)
        .filter(|(_, probe)| probe.node.is_some())
        .max_by(|(_, a), (_, b)| a.recursion.cmp(&b.recursion).then(b.depth.total_cmp(&a.depth)));
    let Some(((x, y), probe)) = smallest else { return Ok(None) };
    let ray = world.camera.lens(width, height)?.ray(f64::from(x) + 0.5, f64::from(y) + 0.5);
    // What is at t on a ray of a lens has t for its depth.
    Ok(Some((ray, probe.depth.into())))
}
