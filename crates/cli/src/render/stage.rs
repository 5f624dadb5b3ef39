//! Everything that a picture needs besides the rays: the scene, its boxes, camera, lights and settings.
//!
//! What the file does not say is chosen here. The choice depends on the solid alone and not on the boxes that rays are
//! tested against, so that these change no pixel.

use std::time::{Duration, Instant};

use csg_graph::{Analysis, BigUint};
use csg_graph_bounds::{Aabb, HyperBoxes, root_box};
use csg_graph_grammar::Look;
use csg_graph_trace::{Camera, Engine, Light, LightSource, Settings, World};

use crate::args::{BoxesArg, MethodArg, RenderArgs};
use crate::load::Loaded;
use crate::{Failure, bounds};

/// The size of a picture that nobody asked for, in pixels.
const DEFAULT_SIZE: u32 = 512;
/// The rays a pixel that nobody asked for.
const DEFAULT_SAMPLES: u32 = 4;

/// The most boxes that the chain algorithm may compute where nobody asked for it: a second or two.
const AFFORDABLE_CHAIN: u32 = 2_000_000;

/// A scene ready to be rendered.
pub(super) struct Stage {
    pub(super) loaded: Loaded,
    pub(super) analysis: Analysis,
    pub(super) settings: Settings,
    /// Which boxes the rays are tested against.
    pub(super) method: Option<MethodArg>,
    pub(super) hyper_boxes: Option<HyperBoxes>,
    pub(super) bounding_time: Duration,
    camera: Camera,
    lights: Vec<Light>,
}

impl Stage {
    /// Analyses and bounds the scene.
    pub(super) fn set(loaded: Loaded, args: &RenderArgs) -> Result<Self, Failure> {
        let analysis = loaded.analyse()?;
        let look = &loaded.scene.look;
        let (width, height) = match args.size {
            Some(size) => (size.width, size.height),
            None => (look.image.width.unwrap_or(DEFAULT_SIZE), look.image.height.unwrap_or(DEFAULT_SIZE)),
        };
        let samples = args.samples.or(look.image.samples).unwrap_or(DEFAULT_SAMPLES);
        let settings = Settings { width, height, samples, view: args.view.into() };

        let start = Instant::now();
        let method = args.boxes.map_or_else(|| Some(usual_method(&analysis)), BoxesArg::method);
        let max_steps = args.limit.once();
        let hyper_boxes = match method {
            Some(method) => Some(bounds::hyper_boxes(method, &loaded, &analysis, max_steps)?),
            None => {
                let what = "without boxes, every ray visits every node of the unfolded tree";
                bounds::refuse_more_than(max_steps, &analysis.instances, &loaded, what)?;
                None
            }
        };
        let bounding_time = start.elapsed();

        let framed = || {
            let root = root_box(&loaded.scene.graph, &loaded.bounds_limits());
            root.map(|root| root.aabb).map_err(|error| bounds::failure(&loaded, error))
        };
        let camera = camera(look, f64::from(width) / f64::from(height), framed)?;
        let lights = lights(look, &camera);
        Ok(Self { analysis, settings, method, hyper_boxes, bounding_time, camera, lights, loaded })
    }

    pub(super) fn world(&self) -> World<'_> {
        World {
            engine: Engine::Reference(&self.loaded.scene.graph, self.hyper_boxes.as_ref()),
            camera: self.camera,
            lights: self.lights.clone(),
            background: self.loaded.scene.look.background.unwrap_or(World::DEFAULT_BACKGROUND),
        }
    }
}

/// The paper's algorithm where its work is small beside that of a picture.
fn usual_method(analysis: &Analysis) -> MethodArg {
    if analysis.chain_boxes <= BigUint::from(AFFORDABLE_CHAIN) { MethodArg::Chain } else { MethodArg::Exact }
}

/// The camera of the file, completed: what is missing of it is taken from the view that frames the solid.
fn camera(
    look: &Look,
    aspect: f64,
    framed: impl FnOnce() -> Result<Aabb, Failure>,
) -> Result<Camera, Failure> {
    let asked = look.camera;
    let fov = asked.fov.unwrap_or(Camera::DEFAULT_FOV);
    if let (Some(eye), Some(target)) = (asked.eye, asked.target) {
        return Ok(Camera { eye, target, up: asked.up.unwrap_or(glam::DVec3::Z), fov });
    }
    let framing = Camera::framing(&framed()?, fov, aspect);
    Ok(Camera {
        eye: asked.eye.unwrap_or(framing.eye),
        target: asked.target.unwrap_or(framing.target),
        up: asked.up.unwrap_or(framing.up),
        fov,
    })
}

/// The lights of the file, or the sun over the camera's shoulder.
fn lights(look: &Look, camera: &Camera) -> Vec<Light> {
    if look.lights.is_empty() {
        return vec![Light::over_shoulder(camera)];
    }
    let light = |light: &csg_graph_grammar::Light| Light {
        source: match light.source {
            csg_graph_grammar::LightSource::Position(position) => LightSource::Point(position),
            csg_graph_grammar::LightSource::Direction(direction) => LightSource::Directional(direction),
        },
        colour: light.color,
        shadow: light.shadow,
    };
    look.lights.iter().map(light).collect()
}
