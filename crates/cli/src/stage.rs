//! Everything that a picture needs besides its rays: the scene, an engine for it, camera and lights.
//!
//! What the file does not say is chosen here. The choice depends on the solid alone and not on the engine or its boxes, so
//! that these change no pixel.

use csg_graph::{AttributeTerm, Graph, Node};
use csg_graph_bounds::{Aabb, root_box};
use csg_graph_grammar::Look;
use csg_graph_trace::{
    Camera, Integrator, Light, LightSource, Probe, RenderError, Settings, Sky, Sun, World, zoom,
};
use rayon::ThreadPool;

use crate::args::Plan;
use crate::engine::Prepared;
use crate::load::Loaded;
use crate::regime::Regime;
use crate::{Failure, bounds, say};

/// A scene ready to be rendered.
pub(crate) struct Stage<'a> {
    pub(crate) loaded: &'a Loaded,
    /// What the engine was made ready by: there is no more memory than is left beside a picture.
    pub(crate) plan: Plan,
    pub(crate) regime: Regime,
    pub(crate) prepared: Prepared<'a>,
    camera: Camera,
    /// How many times as wide as high the picture is.
    aspect: f64,
    lights: Vec<Light>,
}

impl<'a> Stage<'a> {
    /// Analyses the scene and makes an engine ready for pictures with such settings, and layers or none, which have to fit
    /// into the memory. How the scene is traced does not depend on these.
    pub(crate) fn set(
        loaded: &'a Loaded,
        plan: Plan,
        settings: &Settings,
        has_layers: bool,
        memory: usize,
    ) -> Result<Self, Failure> {
        let picture = picture_bytes(settings, has_layers);
        if picture > memory {
            let Settings { width, height, .. } = settings;
            return Err(loaded.refused(format!(
                "a picture of {width} by {height} pixels takes {picture} bytes, and --memory allows {memory}; make it smaller, or raise --memory"
            )));
        }
        let (regime, unlisted) = Regime::of(loaded, plan)?;
        let plan = plan.beside_picture(picture);
        let prepared = Prepared::new(loaded, &regime, plan)?;
        if let Some(unlisted) = unlisted {
            loaded.doubt(&unlisted, regime.limiting_option());
        }
        let aspect = f64::from(settings.width) / f64::from(settings.height);
        let camera = camera(&loaded.scene.look, aspect, || framed(loaded, &regime))?;
        let lights = lights(loaded, settings.integrator, &camera);
        Ok(Self { loaded, plan, regime, prepared, camera, aspect, lights })
    }

    pub(crate) fn world(&self) -> World<'_> {
        World {
            engine: self.prepared.engine(),
            camera: self.camera,
            lights: self.lights.clone(),
            background: background(&self.loaded.scene.look),
        }
    }

    /// Moves the camera so many times closer to the smallest part in sight.
    pub(crate) fn zoom(&mut self, factor: f64) -> Result<(), Failure> {
        self.camera = zoom(&self.world(), self.aspect, factor).map_err(|error| self.failure(error))?;
        Ok(())
    }

    /// Threads to trace with; 0 for one a core.
    pub(crate) fn threads(&self, count: u32) -> Result<ThreadPool, Failure> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(count as usize).build();
        pool.map_err(|error| self.loaded.refused(format!("cannot start the threads: {error}")))
    }

    /// Says of a picture without anything on it where the solid is, and where the camera looks.
    pub(crate) fn warn_of_nothing(&self) {
        let Camera { eye, target, .. } = self.camera;
        let solid = match framed(self.loaded, &self.regime) {
            Ok(aabb) if aabb.is_empty() => "the solid is empty, and ".to_owned(),
            Ok(aabb) => format!("the solid is in {}, and ", bounds::line(&aabb)),
            Err(_) => String::new(),
        };
        let [eye, target] = [eye, target].map(bounds::point);
        say(format_args!(
            "\x1b[1;93mwarning\x1b[0m: {}: no ray hit anything; {solid}the camera looks from {eye} to {target}",
            self.loaded.name
        ));
    }

    /// Why there is no picture.
    pub(crate) fn failure(&self, error: RenderError) -> Failure {
        match error {
            RenderError::Eval(error) => self.loaded.failure(&error.into()),
            other => self.loaded.refused(other),
        }
    }
}

/// The box that a camera frames.
fn framed(loaded: &Loaded, regime: &Regime) -> Result<Aabb, Failure> {
    if let Regime::Vast(limit) = regime {
        return loaded.refined_box(&loaded.envelopes(limit.option)?);
    }
    let root = root_box(&loaded.scene.graph, &loaded.bounds_limits());
    root.map(|root| root.aabb).map_err(|error| bounds::failure(loaded, error))
}

/// What a picture takes until it is written, in bytes.
fn picture_bytes(settings: &Settings, has_layers: bool) -> usize {
    /// Sums of samples, and the picture as floats and bytes.
    const PIXEL: usize = 44;
    /// Sums of squares, and what errors are estimated from.
    const NOISY: usize = 48;
    /// What is known of the first ray through a pixel, tile by tile and row by row, and the layers made of it.
    const LAYERS: usize = 2 * size_of::<Probe>() + 64;
    let noisy = settings.noise.map_or(0, |_| NOISY);
    let layers = if has_layers { LAYERS } else { 0 };
    let pixels = (settings.width as usize).saturating_mul(settings.height as usize);
    pixels.saturating_mul(PIXEL + noisy + layers)
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

/// The sky of the file, completed, or the colour of its background.
fn background(look: &Look) -> Sky {
    let Some(asked) = look.sky else {
        return look.background.map_or(World::DEFAULT_BACKGROUND, Sky::uniform);
    };
    let mut sky = Sky::CLEAR;
    sky.zenith = asked.zenith.unwrap_or(sky.zenith);
    sky.horizon = asked.horizon.unwrap_or(sky.horizon);
    sky.ground = asked.ground.unwrap_or(sky.ground);
    sky.sun = asked.sun.map(|direction| Sun {
        direction,
        colour: asked.sunlight.unwrap_or(glam::DVec3::ONE),
        diameter: asked.disc.unwrap_or(Sun::DIAMETER),
    });
    sky
}

/// The lights of the file. If it has none, and nothing else whose light is followed, one over the camera's shoulder.
fn lights(loaded: &Loaded, integrator: Integrator, camera: &Camera) -> Vec<Light> {
    let look = &loaded.scene.look;
    let has_sun = look.sky.is_some_and(|sky| sky.sun.is_some());
    let shines = integrator == Integrator::Path && is_emissive(&loaded.scene.graph);
    if look.lights.is_empty() && !has_sun && !shines {
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

/// Whether any surface is painted with light of its own.
fn is_emissive(graph: &Graph) -> bool {
    let emits = |node: &Node| match node {
        Node::Attribute(node) => node.terms.iter().any(|(term, _)| *term == AttributeTerm::Emission),
        _ => false,
    };
    graph.nodes().any(|(_, node)| emits(node))
}
