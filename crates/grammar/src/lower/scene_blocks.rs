//! Scene blocks become a [`Look`].

use std::collections::BTreeMap;

use csg_graph::Number;
use glam::DVec3;

use super::Lowering;
use crate::look::{Camera, Image, Integrator, Light, LightSource, Look, Sky};
use crate::names::nearest;
use crate::syntax::{self, Assignment, ExprId, Item, SceneBlock};
use crate::{Diagnostic, Span};

/// The largest diameter of a sun, in degrees.
const DISC: f64 = 90.0;
/// The largest coordinate of a point, so that squares of distances are numbers.
const FAR: f64 = 1e150;
/// The smallest angle of view: where it is smaller, the rays of neighbouring pixels are one.
const NARROW: f64 = 1e-6;

impl Lowering<'_> {
    pub(super) fn scene_blocks(&mut self) -> Look {
        let tree = self.tree;
        let mut look = Look::default();
        let mut seen: BTreeMap<&str, Span> = BTreeMap::new();
        for item in tree.items() {
            let Item::Scene(block) = item else { continue };
            let name = tree.text(block.name);
            let first = *seen.entry(name).or_insert(block.name);
            if first != block.name && name != "light" {
                let report = Diagnostic::error(block.name, format!("there are two blocks `{name}`"));
                self.diagnostics.push(report.label("the second").also(first, "the first"));
            }
            match name {
                "camera" => look.camera = self.camera(block),
                "light" => look.lights.extend(self.light(block)),
                "sky" => look.sky = Some(self.sky(block)),
                "background" => {
                    let mut fields = self.fields(block, &["color"]);
                    look.background = fields.take("color").and_then(|field| self.color(field));
                }
                "image" => look.image = self.image(block),
                // The parser has reported it.
                _ => {}
            }
        }
        if let (Some(sky), Some(background)) = (seen.get("sky"), seen.get("background")) {
            let report = Diagnostic::error(*background, "there is a sky and a background");
            let report = report.label("a background here").also(*sky, "a sky here");
            self.diagnostics
                .push(report.help("both are what rays see that meet nothing; leave one of them out"));
        }
        look
    }

    fn camera(&mut self, block: &SceneBlock) -> Camera {
        let mut fields = self.fields(block, &["eye", "target", "up", "fov"]);
        let eye = fields.take("eye").and_then(|field| self.point(field));
        let target = fields.take("target").and_then(|field| self.point(field));
        let up = fields.take("up").and_then(|field| self.direction(field));
        let fov = fields.take("fov").and_then(|field| {
            let what = format!("an angle of at least {} and below 180 degrees", Number(NARROW));
            self.number_where(field, &what, |fov| (NARROW..180.0).contains(&fov))
        });
        if let (Some(eye), Some(target)) = (eye, target)
            && let Some(label) = indistinct(eye, target)
        {
            let message = "the camera looks at the point where it is";
            self.diagnostics.push(Diagnostic::error(block.name, message).label(label));
        }
        Camera { eye, target, up, fov }
    }

    fn light(&mut self, block: &SceneBlock) -> Option<Light> {
        let mut fields = self.fields(block, &["position", "direction", "color", "shadow"]);
        let (position, direction) = (fields.take("position"), fields.take("direction"));
        let color = fields.take("color").map(|field| self.color(field));
        let shadow = fields
            .take("shadow")
            .map(|field| self.number_where(field, "1 or 0", |shadow| [0.0, 1.0].contains(&shadow)));
        let help =
            "`position = (x, y, z)` is a point, `direction = (x, y, z)` the way in which the light travels";
        let source = match (position, direction) {
            (Some(field), None) => self.point(field).map(LightSource::Position),
            (None, Some(field)) => self.direction(field).map(LightSource::Direction),
            (None, None) => {
                let report =
                    Diagnostic::error(block.name, "the light has neither a position nor a direction");
                self.diagnostics.push(report.label("where does it come from?").help(help));
                None
            }
            (Some(position), Some(direction)) => {
                let report = Diagnostic::error(direction.name, "the light has a position and a direction");
                let report = report.label("a direction here").also(position.name, "a position here");
                self.diagnostics.push(report.help(help));
                None
            }
        };
        Some(Light {
            source: source?,
            color: color.map_or(Some(DVec3::ONE), |color| color)?,
            shadow: shadow.map_or(Some(1.0), |shadow| shadow)? != 0.0,
        })
    }

    fn sky(&mut self, block: &SceneBlock) -> Sky {
        let mut fields = self.fields(block, &["zenith", "horizon", "ground", "sun", "sunlight", "disc"]);
        let sun = fields.take("sun");
        let mut color = |name| fields.take(name).and_then(|field| self.color(field));
        let [zenith, horizon, ground] = ["zenith", "horizon", "ground"].map(&mut color);
        let mut of_sun = |name| {
            let field = fields.take(name)?;
            if sun.is_none() {
                let report =
                    Diagnostic::error(field.name, format!("`{name}` is about the sun, and there is none"));
                let help = "`sun = (x, y, z)` is the direction in which it is seen";
                self.diagnostics.push(report.label("which sun?").help(help));
            }
            Some(field)
        };
        let (sunlight, disc) = (of_sun("sunlight"), of_sun("disc"));
        Sky {
            zenith,
            horizon,
            ground,
            sun: sun.and_then(|field| self.direction(field)),
            sunlight: sunlight.and_then(|field| self.color(field)),
            disc: disc.and_then(|field| {
                let what = format!("an angle above 0 and of at most {} degrees", Number(DISC));
                self.number_where(field, &what, |disc| disc > 0.0 && disc <= DISC)
            }),
        }
    }

    fn image(&mut self, block: &SceneBlock) -> Image {
        let known = ["width", "height", "samples", "integrator", "bounces", "exposure"];
        let mut fields = self.fields(block, &known);
        let integrator = fields.take("integrator").and_then(|field| self.integrator(field));
        let exposure = fields.take("exposure").and_then(|field| {
            let what =
                format!("a number of stops from -{most} to {most}", most = Number(Image::MAX_EXPOSURE));
            self.number_where(field, &what, |stops| stops.abs() <= Image::MAX_EXPOSURE)
        });
        let mut whole = |name, most| fields.take(name).and_then(|field| self.whole(field, most));
        let [width, height] = ["width", "height"].map(|side| whole(side, Image::MAX_SIDE));
        let image = Image {
            width,
            height,
            samples: whole("samples", Image::MAX_SAMPLES),
            integrator,
            bounces: whole("bounces", Image::MAX_BOUNCES),
            exposure,
        };
        let pixels = width.map(u64::from).zip(height.map(u64::from)).map(|(width, height)| width * height);
        if let Some(pixels) = pixels.filter(|pixels| *pixels > Image::MAX_PIXELS) {
            let message = format!("a picture has at most {} pixels", Image::MAX_PIXELS);
            self.diagnostics.push(Diagnostic::error(block.name, message).label(format!("{pixels} pixels")));
        }
        image
    }

    /// A word where fields otherwise have numbers.
    fn integrator(&mut self, field: Assignment) -> Option<Integrator> {
        let tree = self.tree;
        let span = tree.expr_span(field.value);
        match (tree.expr(field.value), tree.text(span)) {
            (syntax::Expr::Missing, _) => None,
            (syntax::Expr::Name, "direct") => Some(Integrator::Direct),
            (syntax::Expr::Name, "path") => Some(Integrator::Path),
            _ => {
                let report = Diagnostic::error(span, "`integrator` is `direct` or `path`");
                let help = "`direct` is light from lamps alone, `path` also from the sky and from one surface to another";
                self.diagnostics.push(report.label("expected one of the two words").help(help));
                None
            }
        }
    }

    /// The fields of a block, after those that it cannot have were reported.
    fn fields(&mut self, block: &SceneBlock, known: &[&str]) -> Fields {
        let tree = self.tree;
        let mut fields = Fields(Vec::new());
        for field in &block.fields.assignments {
            let name = tree.text(field.name);
            if !known.contains(&name) {
                let help = match nearest(name, known.iter().copied()) {
                    Some(known) => format!("did you mean `{known}`?"),
                    None => format!("it has {}", known.join(", ")),
                };
                let message = format!("`{}` has no field `{name}`", tree.text(block.name));
                self.diagnostics.push(Diagnostic::error(field.name, message).label("unknown").help(help));
            } else if let Some((_, first)) = fields.0.iter().find(|(known, _)| known == name) {
                let report = Diagnostic::error(field.name, format!("`{name}` is set twice"));
                self.diagnostics.push(report.label("the second").also(first.name, "the first"));
            } else {
                fields.0.push((name.to_owned(), *field));
            }
        }
        fields
    }

    fn point(&mut self, field: Assignment) -> Option<DVec3> {
        let point = self.triple(field, "a point", "must be finite", |_| true)?;
        if point.abs().max_element() <= FAR {
            return Some(point);
        }
        let message = format!("`{}` is too far away", self.tree.text(field.name));
        let report = Diagnostic::error(self.tree.expr_span(field.value), message).label(shown(point));
        self.diagnostics.push(report.help(format!("coordinates are at most {}", Number(FAR))));
        None
    }

    /// A direction, whose length does not matter: of length 1, so that nobody's squares overflow.
    fn direction(&mut self, field: Assignment) -> Option<DVec3> {
        let direction =
            self.triple(field, "a direction", "must not be zero", |direction| direction != DVec3::ZERO)?;
        Some(unit(direction))
    }

    fn color(&mut self, field: Assignment) -> Option<DVec3> {
        self.triple(field, "a colour", "must not be negative", |color| color.min_element() >= 0.0)
    }

    fn triple(
        &mut self,
        field: Assignment,
        what: &str,
        condition: &str,
        sound: impl Fn(DVec3) -> bool,
    ) -> Option<DVec3> {
        let tree = self.tree;
        let span = tree.expr_span(field.value);
        let items = match tree.expr(field.value) {
            syntax::Expr::Tuple(items) => items.as_slice(),
            syntax::Expr::Missing => return None,
            _ => &[],
        };
        let [x, y, z] = *items else {
            let name = tree.text(field.name);
            let letters = if what == "a colour" { "(r, g, b)" } else { "(x, y, z)" };
            self.diagnostics.push(
                Diagnostic::error(span, format!("`{name}` is {what}, three numbers in parentheses"))
                    .label(format!("expected `{letters}`")),
            );
            return None;
        };
        let [x, y, z] = [x, y, z].map(|item| self.value(item));
        let triple = DVec3::new(x?, y?, z?);
        if triple.is_finite() && sound(triple) {
            return Some(triple);
        }
        let message = format!("`{}` is {what} and {condition}", tree.text(field.name));
        self.diagnostics.push(Diagnostic::error(span, message).label(shown(triple)));
        None
    }

    fn number_where(&mut self, field: Assignment, what: &str, sound: impl Fn(f64) -> bool) -> Option<f64> {
        let value = self.value(field.value)?;
        if sound(value) {
            return Some(value);
        }
        let value = Number(value);
        let message = format!("`{}` is {what}, not {value}", self.tree.text(field.name));
        let span = self.tree.expr_span(field.value);
        self.diagnostics.push(Diagnostic::error(span, message).label(value.to_string()));
        None
    }

    fn whole(&mut self, field: Assignment, most: u32) -> Option<u32> {
        let what = format!("a whole number from 1 to {most}");
        let in_range = |value: f64| value >= 1.0 && value <= f64::from(most) && value.fract() == 0.0;
        let value = self.number_where(field, &what, in_range)?;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "checked to be whole and in range"
        )]
        Some(value as u32)
    }

    fn value(&mut self, id: ExprId) -> Option<f64> {
        let expr = self.scope.expr(self.tree, &self.chance.sites, id, &mut self.diagnostics)?;
        let mut reports = Vec::new();
        let value = self.evaluate("the value", &expr, self.tree.expr_span(id), &mut reports);
        self.diagnostics.extend(reports);
        value
    }
}

/// The fields of one block, each to be taken once.
struct Fields(Vec<(String, Assignment)>);

impl Fields {
    fn take(&mut self, name: &str) -> Option<Assignment> {
        let at = self.0.iter().position(|(known, _)| known == name)?;
        Some(self.0.swap_remove(at).1)
    }
}

/// Why there is no direction from one point to another.
fn indistinct(eye: DVec3, target: DVec3) -> Option<&'static str> {
    if eye == target {
        Some("`eye` and `target` are the same")
    } else if (target - eye).try_normalize().is_none() {
        Some("`eye` and `target` are too close together")
    } else {
        None
    }
}

/// A vector that is not zero, with length 1. Its squares may be too large or too small for numbers.
fn unit(vector: DVec3) -> DVec3 {
    (vector / vector.abs().max_element()).normalize()
}

fn shown(triple: DVec3) -> String {
    format!("({}, {}, {})", Number(triple.x), Number(triple.y), Number(triple.z))
}
