//! Surfaces, which attribute nodes paint, and the hits that show them.

use csg_graph::{AttributeTerm, NodeId};
use glam::DVec3;

/// The look of a surface. Carried down the graph like a transformation: an attribute node changes terms for all below it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Surface {
    /// Colour, in linear light.
    pub pigment: DVec3,
    /// The part of the pigment that needs no light.
    pub ambient: f64,
    /// The part of the pigment that a light facing the surface adds.
    pub diffuse: f64,
    /// The strength of the highlight.
    pub specular: f64,
    /// The exponent of the highlight.
    pub shininess: f64,
    /// The strength of its own light, which is the pigment times this.
    pub emission: f64,
    /// The part of it that is metal, from 0 to 1.
    pub metal: f64,
    /// How rough the metal is, from 0 for a mirror to 1.
    pub roughness: f64,
    /// The part that is glass, from 0 to 1, of what is not metal.
    pub glass: f64,
    /// The index of refraction of the glass.
    pub ior: f64,
    /// How fast the glass swallows light: what is left of it after a unit of length is the pigment to this power.
    pub absorption: f64,
}

impl Default for Surface {
    /// White and matt.
    fn default() -> Self {
        Self {
            pigment: DVec3::ONE,
            ambient: 0.2,
            diffuse: 0.8,
            specular: 0.0,
            shininess: 40.0,
            emission: 0.0,
            metal: 0.0,
            roughness: 0.0,
            glass: 0.0,
            ior: 1.5,
            absorption: 1.0,
        }
    }
}

impl Surface {
    /// Changes one term. One that means nothing to this crate is ignored.
    pub fn set(&mut self, term: AttributeTerm, value: f64) {
        match term {
            AttributeTerm::Red => self.pigment.x = value,
            AttributeTerm::Green => self.pigment.y = value,
            AttributeTerm::Blue => self.pigment.z = value,
            AttributeTerm::Ambient => self.ambient = value,
            AttributeTerm::Diffuse => self.diffuse = value,
            AttributeTerm::Specular => self.specular = value,
            AttributeTerm::Shininess => self.shininess = value,
            AttributeTerm::Emission => self.emission = value,
            AttributeTerm::Metal => self.metal = value,
            AttributeTerm::Roughness => self.roughness = value,
            AttributeTerm::Glass => self.glass = value,
            AttributeTerm::Ior => self.ior = value,
            AttributeTerm::Absorption => self.absorption = value,
            _ => {}
        }
    }

    /// The part of it that is neither metal nor glass.
    pub(crate) fn matt(&self) -> f64 {
        (1.0 - self.metal) * (1.0 - self.glass)
    }
}

/// Where a ray meets the solid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// The parameter of the ray, in units of its direction.
    pub t: f64,
    /// The point, in the world.
    pub point: DVec3,
    /// The outward normal of the solid in the world, of length 1. In a hole that was subtracted it points into the hole.
    pub normal: DVec3,
    /// The surface there. A hole has the surface of what was subtracted, where that has attributes of its own.
    pub surface: Surface,
    /// The primitive node whose surface it is.
    pub node: NodeId,
    /// The recursion depth: the number of S-nodes on the path to the primitive.
    pub depth: u32,
}
