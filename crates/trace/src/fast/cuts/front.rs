//! Where the rays of a packet are: the t that each has come to, by which face, and what is known of it.

use fearless_simd::{Select, Simd, SimdBase, f64x8};

use crate::fast::hits::{Hits, Place};
use crate::fast::lanes::{HALF, LANES, Lanes, Mask, bits};

/// Where the rays are.
#[derive(Debug)]
pub(super) struct Front {
    pub(super) t: Lanes,
    /// Where A ends, or the ray.
    pub(super) ends: Lanes,
    /// The faces that they have come to t by.
    pub(super) faces: [Place; LANES],
    /// Those that have moved since they started from the top.
    pub(super) moved: Mask,
    /// Those that may have several faces at t.
    pub(super) tied: Mask,
    /// Those that have to be asked alone.
    pub(super) alone: Mask,
    /// Counts all changes of t.
    pub(super) changes: u32,
}

impl Default for Front {
    fn default() -> Self {
        let (t, faces) = (Lanes::ZERO, [Place::NONE; LANES]);
        Self { t, ends: t, faces, moved: 0, tied: 0, alone: 0, changes: 0 }
    }
}

impl Front {
    /// Begins where rays enter A, or at `start` if they are in A there, if that is before their ends. Says for which it is.
    #[inline(always)]
    pub(super) fn begin<S: Simd>(
        &mut self,
        simd: S,
        [enters, exits]: &[Lanes; 2],
        (start, ends): (f64, &Lanes),
        face: Place,
    ) -> Mask {
        *self = Self { faces: [face; LANES], ..Self::default() };
        let mut met = 0;
        let start = f64x8::splat(simd, start);
        for half in 0..2 {
            let (enter, exit, end) = (enters.half(simd, half), exits.half(simd, half), ends.half(simd, half));
            let t = enter.simd_gt(start).select(enter, start);
            self.t.set_half(half, t);
            self.ends.set_half(half, exit.simd_lt(end).select(exit, end));
            self.tied |= bits(enter.simd_eq(start)) << (half * HALF);
            met |= bits(t.simd_lt(exit) & t.simd_le(end)) << (half * HALF);
        }
        met
    }

    /// The rays that have not come to where A ends, and not beyond their own ends.
    #[inline(always)]
    pub(super) fn going<S: Simd>(&self, simd: S, exits: &Lanes) -> Mask {
        let mut going = 0;
        for half in 0..2 {
            let t = self.t.half(simd, half);
            let is_before = t.simd_lt(exits.half(simd, half)) & t.simd_le(self.ends.half(simd, half));
            going |= bits(is_before) << (half * HALF);
        }
        going
    }

    /// The rays that have not left their origins.
    #[inline(always)]
    pub(super) fn at_origin<S: Simd>(&self, simd: S) -> Mask {
        let zero = f64x8::splat(simd, 0.0);
        bits(self.t.half(simd, 0).simd_le(zero)) | bits(self.t.half(simd, 1).simd_le(zero)) << HALF
    }

    /// Takes the span of a part on one ray: the first t that is in it, and the first that is not.
    #[inline(always)]
    #[expect(clippy::float_cmp, reason = "faces that differ by an ulp do not coincide")]
    pub(super) fn take(&mut self, hits: &Hits, lane: usize, [enter, exit]: [f64; 2], place: Place) {
        let t = self.t.0[lane];
        // The face that the ray has come to t by is not another one.
        if enter < exit && (enter == t || exit == t) && !hits.is_same(self.faces[lane], place) {
            self.tied |= 1 << lane;
        }
        if enter <= t && t < exit {
            self.move_on(lane, exit, Place { turned: true, ..place });
        }
    }

    #[inline(always)]
    pub(super) fn move_on(&mut self, lane: usize, t: f64, face: Place) {
        self.t.0[lane] = t;
        self.faces[lane] = face;
        // Other faces at the last t are behind.
        self.tied &= !(1 << lane);
        self.moved |= 1 << lane;
        self.changes += 1;
    }
}
