//! What is asked about an operand, and how an operator makes one answer of those of its operands.
//!
//! \[ROTH82\]'s combination of spans with nothing evaluated ahead. To be inside of A ∩ B is to be inside of both: A is asked,
//! then B from there on, then A again, until they agree on one t. To be outside is to leave either. A \\ B is A ∩ ¬B, where
//! to be inside of ¬B is to be outside of B. So the right operand of \\ is asked only where the left one is, and both
//! operands of ∩ only where the other one is.

use csg_graph::Operator;

use crate::Ray;
use crate::fast::hits::Place;
use crate::shapes::Extents;

/// What is asked: where the ray comes to be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Seek {
    Inside,
    Outside,
}

/// A question about an operand. An answer beyond the limit says only that it is beyond.
#[derive(Clone, Copy, Debug)]
pub(super) struct Question {
    pub(super) seek: Seek,
    pub(super) from: f64,
    pub(super) limit: f64,
    /// Whether what is asked is cut out of the result.
    pub(super) is_cut: bool,
}

/// Where the ray comes to be there, and the face that it passes: unless there are several at this t, or none because it
/// has been there before.
#[derive(Clone, Copy, Debug)]
pub(super) struct Answer {
    pub(super) t: f64,
    /// Turned if the ray leaves its primitive there.
    pub(super) face: Place,
}

/// An operator that waits for an operand.
#[derive(Clone, Copy, Debug)]
pub(super) struct Operation {
    pub(super) question: Question,
    pub(super) operator: Operator,
    pub(super) operands: [u32; 2],
    pub(super) ray: Ray,
    pub(super) way: u32,
    /// Which operand was asked last.
    pub(super) asked: usize,
    /// What the other operand has answered.
    pub(super) other: Option<Answer>,
}

/// What follows an answer.
pub(super) enum Next {
    Answer(Answer),
    /// A super-node.
    Ask(u32, Question),
}

impl Answer {
    pub(super) const NEVER: Self = Self::at(f64::INFINITY);

    pub(super) const fn at(t: f64) -> Self {
        Self { t, face: Place::NONE }
    }
}

impl Question {
    /// What a primitive answers.
    #[inline(always)]
    pub(super) fn answer(&self, extents: &Extents, face: Place) -> Answer {
        let from = self.from;
        let face = Place { turned: self.seek == Seek::Outside, ..face };
        match self.seek {
            Seek::Inside => {
                let extent = extents.iter().find(|[enter, exit]| enter < exit && from < *exit);
                extent.map_or(Answer::NEVER, |[enter, _]| Answer { t: enter.max(from), face })
            }
            Seek::Outside => {
                let extent = extents.iter().find(|[enter, exit]| *enter <= from && from < *exit);
                extent.map_or(Answer::at(from), |[_, exit]| Answer { t: *exit, face })
            }
        }
    }

    /// Whether a primitive has a face just where it is asked.
    #[inline(always)]
    #[expect(clippy::float_cmp, reason = "faces that differ by an ulp do not coincide")]
    pub(super) fn begins_at_face(&self, extents: &Extents) -> bool {
        extents.iter().any(|[enter, exit]| enter < exit && (*enter == self.from || *exit == self.from))
    }

    /// What an empty solid answers.
    pub(super) fn nowhere(&self) -> Answer {
        match self.seek {
            Seek::Inside => Answer::NEVER,
            Seek::Outside => Answer::at(self.from),
        }
    }
}

impl Operation {
    /// Goes on with the answer of the operand that was asked last.
    #[inline(always)]
    pub(super) fn resume(&mut self, answer: Answer) -> Next {
        let Question { seek, from, limit, .. } = self.question;
        match (seek, self.other) {
            (Seek::Inside, _) if answer.t > limit || answer.t == f64::INFINITY => Next::Answer(Answer::NEVER),
            // This one is inside where the other has come inside.
            (Seek::Inside, Some(other)) if answer.t <= other.t => Next::Answer(other),
            (Seek::Inside, _) => self.ask_other(answer, answer.t, limit),
            (Seek::Outside, Some(left)) => Next::Answer(if answer.t < left.t { answer } else { left }),
            (Seek::Outside, None) if answer.t <= from => Next::Answer(answer),
            (Seek::Outside, None) => self.ask_other(answer, from, answer.t.min(limit)),
        }
    }

    #[inline(always)]
    fn ask_other(&mut self, answer: Answer, from: f64, limit: f64) -> Next {
        self.other = Some(answer);
        self.asked = 1 - self.asked;
        let seek = match (self.question.seek, self.operator, self.asked) {
            (Seek::Inside, Operator::Difference, 1) => Seek::Outside,
            (Seek::Outside, Operator::Difference, 1) => Seek::Inside,
            (seek, ..) => seek,
        };
        let is_cut = self.question.is_cut != (self.operator == Operator::Difference && self.asked == 1);
        Next::Ask(self.operands[self.asked], Question { seek, from, limit, is_cut })
    }
}
