//! Going closer to what is small.

use crate::{Camera, RenderError, World, survey};

/// Rays that look for the smallest part: so many across, and as many down.
const LOOK: u32 = 256;

/// The camera of a world, `factor` times as close to the smallest part that it sees: what it meets after the deepest
/// recursion, of several the nearest one. That comes to the middle of the picture, seen
/// along the ray that found it, so that nothing can be in the way. A camera that sees nothing stays where it is.
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
/// let closer = zoom(&world, 10.0)?;
/// assert!(closer.target.distance(DVec3::new(0.0, -1.0, 0.0)) < 0.1);
/// assert!((closer.eye.distance(closer.target) - 1.0).abs() < 1e-3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// As [`survey`](crate::survey).
///
/// # Panics
/// If the boxes are of another graph.
pub fn zoom(world: &World<'_>, factor: f64) -> Result<Camera, RenderError> {
    let probes = survey(world, LOOK, LOOK)?;
    let pixels = (0..LOOK).flat_map(|y| (0..LOOK).map(move |x| (x, y)));
    let smallest = pixels
        .zip(&probes)
        .filter(|(_, probe)| probe.node.is_some())
        .max_by(|(_, a), (_, b)| a.recursion.cmp(&b.recursion).then(b.depth.total_cmp(&a.depth)));
    let Some(((x, y), _)) = smallest else { return Ok(world.camera) };
    let ray = world.camera.lens(LOOK, LOOK)?.ray(f64::from(x) + 0.5, f64::from(y) + 0.5);
    let mut hits = Vec::new();
    world.engine.tracer().nearest(&[ray], &mut hits)?;
    let Some(hit) = hits[0] else { return Ok(world.camera) };
    Ok(Camera { eye: hit.point + (world.camera.eye - hit.point) / factor, target: hit.point, ..world.camera })
}
