//! What a picture shows: the shaded solid, the paper's colour plate, or what the tracer knows about it.
//!
//! Some views are relative to an extreme of the whole picture, such as its deepest recursion, which is known only when all
//! rays are traced. So a pixel is first *exposed*: it sums what its samples contribute, and the extremes are noted. Then the
//! picture is *developed*, as often as anyone wants to see what there is so far.

use std::ops::Range;

use glam::DVec3;

use crate::narrow::narrow;
use crate::srgb;
use crate::tiles::Tiles;

/// What a picture shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum View {
    /// The solid in its colours and lights.
    #[default]
    Shaded,
    /// The paper's colour plate: the shaded solid before a background that shows how deep in the recursion each ray was
    /// turned away. Odd levels are red and even ones blue; deeper is brighter, the deepest of the picture at full
    /// brightness; a ray that came to no recursion is black.
    Plate,
    /// The normal n, outward from the solid, as (n + 1) / 2 in the bytes of the picture. The background is black.
    Normal,
    /// The depth along the viewing direction: white is the nearest of the picture, dark grey the farthest, and the
    /// background is black. Linear in the bytes of the picture.
    Depth,
    /// The tests of boxes and primitives that a sample of the pixel took, its shadow rays' among them, from black through red and
    /// yellow to the most of the picture.
    Cost,
}

/// What the samples of all pixels have contributed: sums, which the next samples can be added to at any time.
///
/// They are in double precision and in the order of the samples, so that it makes no difference how often they were
/// left and taken up again. Pixels are in the order of [`Tile::start`](crate::tiles::Tile::start), where those of a tile
/// follow each other. All memory is asked for at once, and the system gives each page of it when a pixel there is exposed.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Exposure {
    /// What can be seen as it is, of each pixel, in the views that have such a thing.
    pub(crate) light: Vec<[f64; 3]>,
    /// What is relative to an extreme, in other views: for the plate, the levels that are odd and those that are even;
    /// for the depth view, the depths of hits and their number; for the cost view, the tests.
    pub(crate) gauges: Vec<[f64; 2]>,
    /// What every other sample added to the light, if anyone wants to know how far both halves differ.
    pub(crate) halves: Vec<[f64; 3]>,
    /// Of each tile.
    pub(crate) extremes: Vec<Extremes>,
}

/// What belongs to some pixels of a tile that follow each other.
#[derive(Debug)]
pub(crate) struct Patch<'a> {
    light: &'a mut [[f64; 3]],
    gauges: &'a mut [[f64; 2]],
    halves: &'a mut [[f64; 3]],
    extremes: &'a mut Extremes,
}

impl Exposure {
    /// Nothing yet.
    pub(crate) fn new(view: View, tiles: Tiles, is_judged: bool) -> Self {
        let pixels = tiles.width as usize * tiles.height as usize;
        let if_needed = |needed: bool| if needed { pixels } else { 0 };
        let has_light = matches!(view, View::Shaded | View::Plate | View::Normal);
        let has_gauges = matches!(view, View::Plate | View::Depth | View::Cost);
        Self {
            light: vec![[0.0; 3]; if_needed(has_light)],
            gauges: vec![[0.0; 2]; if_needed(has_gauges)],
            halves: vec![[0.0; 3]; if_needed(has_light && is_judged)],
            extremes: vec![Extremes::NONE; tiles.count() as usize],
        }
    }

    /// The patches of the tiles.
    pub(crate) fn patches(&mut self, tiles: Tiles) -> impl Iterator<Item = Patch<'_>> {
        let Self { light, gauges, halves, extremes } = self;
        let (mut light, mut gauges, mut halves) = (&mut light[..], &mut gauges[..], &mut halves[..]);
        tiles.iter().zip(extremes).map(move |(tile, extremes)| {
            let count = tile.pixel_count();
            let (light, gauges) = (first(&mut light, count), first(&mut gauges, count));
            Patch { light, gauges, halves: first(&mut halves, count), extremes }
        })
    }

    /// The mean of the samples of the cost view.
    pub(crate) fn mean_cost(&self, place: usize, samples: u32) -> f64 {
        self.gauges[place][0] / f64::from(samples)
    }

    /// Something of pixels that follow each other, made from what they are in linear light, given how many samples each
    /// has had, and the extremes of the whole picture. Without samples, they are black.
    #[inline]
    pub(crate) fn develop<T>(
        &self,
        view: View,
        places: Range<usize>,
        samples: u32,
        extremes: &Extremes,
        to: &mut [T],
        of: impl Fn([f32; 3]) -> T,
    ) {
        if samples == 0 {
            to.iter_mut().for_each(|pixel| *pixel = of([0.0; 3]));
        } else if let View::Shaded | View::Normal = view {
            for (pixel, light) in to.iter_mut().zip(&self.light[places]) {
                *pixel = of(mean(*light, samples).map(narrow));
            }
        } else {
            for (pixel, place) in to.iter_mut().zip(places) {
                let light = self.light.get(place).map_or([0.0; 3], |light| mean(*light, samples));
                let gauges = self.gauges.get(place).map_or([0.0; 2], |gauges| mean(*gauges, samples));
                *pixel = of(view.develop(light.into(), gauges, extremes).to_array().map(narrow));
            }
        }
    }
}

impl Patch<'_> {
    /// Takes its first pixels away.
    pub(crate) fn split_off(&mut self, count: usize) -> Patch<'_> {
        let (light, gauges) = (first(&mut self.light, count), first(&mut self.gauges, count));
        Patch { light, gauges, halves: first(&mut self.halves, count), extremes: self.extremes }
    }

    /// Sets all sums to zero, which they are. New memory that is read before it is written is given twice by the system:
    /// first a page of zeros that all share, and then one to write to.
    pub(crate) fn touch(&mut self) {
        self.light.fill([0.0; 3]);
        self.gauges.fill([0.0; 2]);
        self.halves.fill([0.0; 3]);
    }

    /// A sample that has a colour of its own, and the number of the sample.
    #[inline]
    pub(crate) fn colour(&mut self, place: usize, number: u32, light: DVec3) {
        add(&mut self.light[place], light);
        if let Some(half) = self.halves.get_mut(place)
            && number.is_multiple_of(2)
        {
            add(half, light);
        }
    }

    /// A sample of the plate's background.
    pub(crate) fn missed(&mut self, place: usize, level: u32) {
        let is_even = usize::from(level.is_multiple_of(2));
        let level = f64::from(level);
        self.gauges[place][is_even] += level;
        self.extremes.note(level);
    }

    /// A sample of the normal view.
    pub(crate) fn normal(&mut self, place: usize, number: u32, normal: DVec3) {
        self.colour(place, number, (normal * 0.5 + 0.5).map(srgb::decode));
    }

    /// A sample of the depth view that is a hit.
    pub(crate) fn depth(&mut self, place: usize, depth: f64) {
        let [depths, hits] = &mut self.gauges[place];
        *depths += depth;
        *hits += 1.0;
        self.extremes.note(depth);
    }

    /// What some samples of the cost view took.
    pub(crate) fn cost(&mut self, place: usize, tests: f64) {
        self.gauges[place][0] += tests;
    }
}

/// Takes the first ones away, unless there are none in this view.
fn first<'a, T>(sums: &mut &'a mut [T], count: usize) -> &'a mut [T] {
    sums.split_off_mut(..count).unwrap_or_default()
}

#[inline]
fn add(sum: &mut [f64; 3], light: DVec3) {
    *sum = (DVec3::from(*sum) + light).to_array();
}

/// Sums divided by the number of samples.
#[inline]
fn mean<const N: usize>(sums: [f64; N], samples: u32) -> [f64; N] {
    // Where that is one, dividing would take longer than all else that is done here.
    if samples == 1 { sums } else { sums.map(|sum| sum / f64::from(samples)) }
}

/// The least and the greatest of what a view measures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Extremes {
    pub(crate) least: f64,
    pub(crate) greatest: f64,
}

impl Extremes {
    pub(crate) const NONE: Self = Self { least: f64::INFINITY, greatest: f64::NEG_INFINITY };

    pub(crate) fn note(&mut self, value: f64) {
        *self = self.join(Self { least: value, greatest: value });
    }

    pub(crate) fn join(self, other: Self) -> Self {
        Self { least: self.least.min(other.least), greatest: self.greatest.max(other.greatest) }
    }
}

/// The plate's odd levels.
const RED: DVec3 = DVec3::new(1.0, 0.05, 0.03);

/// The plate's even levels.
const BLUE: DVec3 = DVec3::new(0.08, 0.2, 1.0);

/// How bright the farthest hit of the depth view is.
const FARTHEST: f64 = 0.15;

/// The colour scale of the cost view, encoded as sRGB: five points of the perceptually uniform scale "inferno" of
/// matplotlib.
const HEAT: [[f64; 3]; 5] =
    [[0.0, 0.0, 4.0], [87.0, 16.0, 110.0], [188.0, 55.0, 84.0], [249.0, 142.0, 9.0], [252.0, 255.0, 164.0]];

impl View {
    /// The pixel in linear light, from the means of its samples and the extremes of the whole picture.
    fn develop(self, light: DVec3, [first, second]: [f64; 2], extremes: &Extremes) -> DVec3 {
        match self {
            Self::Plate if extremes.greatest > 0.0 => {
                light + (RED * first + BLUE * second) / extremes.greatest
            }
            Self::Shaded | Self::Normal | Self::Plate => light,
            Self::Depth => {
                let range = extremes.greatest - extremes.least;
                // How far the hits are behind the nearest one; flat pictures are all nearest.
                let behind = if range > 0.0 { (first - second * extremes.least) / range } else { 0.0 };
                DVec3::splat(srgb::decode(second - (1.0 - FARTHEST) * behind))
            }
            Self::Cost if extremes.greatest > 0.0 => heat(first / extremes.greatest),
            Self::Cost => heat(0.0),
        }
    }
}

/// A colour for a value from 0 to 1, in linear light.
fn heat(value: f64) -> DVec3 {
    let segments = HEAT.windows(2).zip([0.0, 1.0, 2.0, 3.0]);
    let position = value.clamp(0.0, 1.0) * 4.0;
    let (ends, start) =
        segments.take_while(|(_, start)| *start <= position).last().unwrap_or((&HEAT[..2], 0.0));
    let [from, to] = [ends[0], ends[1]].map(|colour| DVec3::from(colour) / 255.0);
    from.lerp(to, position - start).map(srgb::decode)
}
