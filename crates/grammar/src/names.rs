//! What names mean, and which known name an unknown one was probably meant to be.

use csg_graph::{Function, Operator, PrimitiveKind, TransformKind};

use crate::Diagnostic;

/// The prefix that sets the pigment.
pub(crate) const COLOR: &str = "color";
/// The prefix that sets how a surface takes light.
pub(crate) const MATERIAL: &str = "material";
/// The signatures of the attributes, for messages.
pub(crate) const COLOR_SIGNATURE: &str = "color(r, g, b)";
/// The constant.
pub(crate) const PI: &str = "pi";
/// The parameter that random numbers are drawn from.
pub(crate) const SEED: &str = "seed";
/// The scene blocks.
pub(crate) const BLOCKS: [&str; 5] = ["camera", "light", "sky", "background", "image"];

/// Whether a name stands before a factor.
pub(crate) fn is_prefix(name: &str) -> bool {
    TransformKind::named(name).is_some() || name == COLOR || name == MATERIAL
}

/// Whether the language gives a name its meaning among solids, so that no symbol and no macro can have it.
pub(crate) fn is_built_in(name: &str) -> bool {
    is_prefix(name) || PrimitiveKind::named(name).is_some()
}

/// The prefixes.
pub(crate) fn prefixes<'a>() -> impl Iterator<Item = &'a str> {
    TransformKind::ALL.iter().map(|kind| kind.name()).chain([COLOR, MATERIAL])
}

/// The primitives.
pub(crate) fn primitives<'a>() -> impl Iterator<Item = &'a str> {
    PrimitiveKind::ALL.iter().map(|kind| kind.name())
}

/// The functions.
pub(crate) fn functions<'a>() -> impl Iterator<Item = &'a str> {
    Function::ALL.iter().map(|function| function.name())
}

/// What other programs call the things of this language.
const ELSEWHERE: [(&str, &str); 26] = [
    ("translate", "move"),
    ("rotate", "rot"),
    ("rotatex", "rotx"),
    ("rotatey", "roty"),
    ("rotatez", "rotz"),
    ("mirror", "flipyz"),
    ("colour", "color"),
    ("pigment", "color"),
    ("texture", "material"),
    ("box", "cube"),
    ("ball", "sphere"),
    ("tube", "cylinder"),
    ("plane", "halfspace"),
    ("prism", "hull"),
    ("polyhedron", "hull"),
    ("log", "ln"),
    ("lerp", "mix"),
    ("random", "rand"),
    ("rnd", "rand"),
    ("gauss", "normal"),
    ("perlin", "noise"),
    ("choose", "pick"),
    ("background_color", "background"),
    ("location", "eye"),
    ("look_at", "target"),
    ("angle", "fov"),
];

/// What a word means in other languages that this one writes without words.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Idiom {
    Operator(Operator),
    Loop,
}

impl Idiom {
    /// What a word means elsewhere.
    pub(crate) fn of(word: &str) -> Option<Self> {
        Some(match word {
            "union" | "merge" | "or" => Self::Operator(Operator::Union),
            "intersection" | "intersect" | "and" => Self::Operator(Operator::Intersection),
            "difference" | "subtract" | "minus" => Self::Operator(Operator::Difference),
            "for" | "while" | "repeat" | "loop" => Self::Loop,
            _ => return None,
        })
    }

    /// How this language writes it.
    pub(crate) fn here(self) -> String {
        match self {
            Self::Operator(operator) => {
                format!("the {} of solids is written `a {} b`", operator.name(), operator.ascii_sign())
            }
            Self::Loop => "there are no loops: a rule that leads back to its symbol repeats, and counts: `{n = n - 1} TREE`".to_owned(),
        }
    }
}

/// The candidate that `name` is most likely a slip of: the nearest in edits, if that is near. The first of equals wins.
pub(crate) fn nearest<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let lower = name.to_lowercase();
    let elsewhere = ELSEWHERE.iter().find(|(other, _)| *other == lower).map(|(_, ours)| *ours);
    let length = name.chars().count();
    let tolerance = match length {
        0..=1 => 0,
        2..=5 => 1,
        6..=8 => 2,
        _ => 3,
    };
    candidates
        .into_iter()
        .filter_map(|candidate| {
            if elsewhere == Some(candidate) {
                return Some((0, candidate));
            }
            // The edits are at least as many as the lengths differ by, which costs less to find out.
            if candidate.chars().count().abs_diff(length) > tolerance {
                return None;
            }
            let same = candidate.to_lowercase() == lower;
            let distance = if same { 0 } else { strsim::osa_distance(name, candidate) };
            (distance <= tolerance).then_some((distance, candidate))
        })
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, candidate)| candidate)
}

/// How many diagnostics come with a guess at the name that was meant.
const GUESSES: usize = 100;

/// [`nearest`] for the next of the diagnostics. Each guess looks at all candidates; where so much has been told that nobody
/// reads on, it is left out, so that a file with many mistakes takes no longer than one without.
pub(crate) fn guess<'a>(
    told: &[Diagnostic],
    name: &str,
    candidates: impl IntoIterator<Item = &'a str>,
) -> Option<&'a str> {
    if told.len() < GUESSES { nearest(name, candidates) } else { None }
}

#[cfg(test)]
mod tests {
    use super::nearest;

    #[test]
    fn slips_are_recognised_and_other_words_are_not() {
        let known = ["sphere", "cylinder", "move", "n", "cnt"];
        assert_eq!(nearest("spheer", known), Some("sphere"));
        assert_eq!(nearest("ctn", known), Some("cnt"));
        assert_eq!(nearest("CNT", known), Some("cnt"));
        assert_eq!(nearest("translate", known), Some("move"));
        assert_eq!(nearest("leaf", known), None);
        assert_eq!(nearest("m", known), None);
    }
}
