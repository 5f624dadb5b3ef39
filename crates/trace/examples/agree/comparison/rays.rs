//! The rays of a comparison: those of a picture, those across the whole scene, and those that come off surfaces.

use csg_graph::EvalError;
use csg_graph_bounds::Aabb;
use csg_graph_trace::{Camera, CameraError, Hit, Lens, PACKET, Ray};
use glam::DVec3;

/// The rays of a block: a packet of each kind, and one more from what each of them met.
pub(crate) const BLOCK: usize = 4 * PACKET;

/// The picture that primary rays are taken from, in pixels.
const SIDE: u32 = 512;

/// How far off its surface a ray starts, relative to coordinates: where the program starts its shadow rays.
const OFFSET: f64 = 1e-10;

/// Rays of one scene, by the numbers of their blocks.
pub(crate) struct Rays {
    lens: Lens,
    bounds: Aabb,
}

impl Rays {
    pub(crate) fn new(camera: &Camera, bounds: &Aabb) -> Result<Self, CameraError> {
        Ok(Self { lens: camera.lens(SIDE, SIDE)?, bounds: *bounds })
    }

    /// Asks for the hits of the packets of a block, one after the other.
    pub(crate) fn block(
        &self,
        number: u64,
        mut ask: impl FnMut(&[Ray; PACKET]) -> Result<[Option<Hit>; PACKET], EvalError>,
    ) -> Result<(), EvalError> {
        let random = &mut Random(number << 20);
        for packet in [self.primary(random), self.chords(random)] {
            let hits = ask(&packet)?;
            let met: Vec<&Hit> = hits.iter().flatten().collect();
            let bounced = match met.len() {
                0 => self.chords(random),
                count => std::array::from_fn(|lane| bounced(met[lane % count], random)),
            };
            ask(&bounced)?;
        }
        Ok(())
    }

    /// Through a square of pixels anywhere in the picture.
    fn primary(&self, random: &mut Random) -> [Ray; PACKET] {
        let [x, y] = [random.share(), random.share()].map(|share| share * f64::from(SIDE - 4));
        std::array::from_fn(|lane| self.lens.ray(x + (lane % 4) as f64, y + (lane / 4) as f64))
    }

    /// From outside of the solid's box through two points of the box.
    fn chords(&self, random: &mut Random) -> [Ray; PACKET] {
        let Aabb { min, .. } = self.bounds;
        let size = self.bounds.size();
        std::array::from_fn(|_| {
            let [one, other] = [random.place(), random.place()].map(|place| min + size * place);
            let direction = other - one;
            let origin = one - direction.normalize_or(DVec3::X) * (1.5 * size.length());
            Ray { origin, direction }
        })
    }
}

/// Off a surface, in any direction away from it.
fn bounced(hit: &Hit, random: &mut Random) -> Ray {
    let size = hit.point.abs().max_element();
    let direction = random.place() * 2.0 - 1.0;
    let outward = hit.normal * (direction.length() * 1.001) + direction;
    Ray { origin: hit.point + hit.normal * (OFFSET * size), direction: outward }
}

/// Random numbers, by `SplitMix64`.
struct Random(u64);

impl Random {
    /// From 0 to 1.
    fn share(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut bits = self.0;
        bits = (bits ^ bits >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ bits >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        (bits >> 11 ^ bits >> 42) as f64 / (1_u64 << 53) as f64
    }

    fn place(&mut self) -> DVec3 {
        DVec3::new(self.share(), self.share(), self.share())
    }
}
