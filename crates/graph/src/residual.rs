//! Partial evaluation: what is left of the range of an expression where the intervals of most parameters are known
//! beforehand.
//!
//! Whoever asks for the range of an expression again and again, with other intervals for a few of its parameters, need not
//! calculate anew what does not depend on these. Of `(a + b) / 2 + rough * (hash(2 * x + 1, y) - 0.5)` with the heights `a` and
//! `b` to be given, there remains (a + b) / 2 plus an interval.

use crate::expr::Op;
use crate::{Binary, Expr, Function, Interval, ParamId, Unary};

/// What is left of the [range](Expr::range) of an expression: [`Expr::residual`] makes it.
#[derive(Clone, Debug, PartialEq)]
pub struct Residual {
    steps: Box<[Step]>,
    /// The most intervals that are on the stack at a time.
    depth: usize,
}

/// One step of the postfix program.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Step {
    Known(Interval),
    /// The one that is given at that place.
    Given(usize),
    Unary(Unary),
    Binary(Binary),
    Call(Function, usize),
}

impl Expr {
    /// What is left of the [range](Self::range) once each parameter is anywhere in its interval of `values`, save those for
    /// which `given` has a place among the intervals that will be given.
    ///
    /// ```
    /// use csg_graph::{Expr, GraphBuilder, Interval};
    ///
    /// let mut builder = GraphBuilder::new();
    /// let [x, y] = ["x", "y"].map(|name| builder.param(name, 0.0));
    /// let expr = Expr::from(x) * Expr::from(x) + y;
    /// let values = [Interval::new(1.0, 3.0), Interval::ALL];
    /// let residual = expr.residual(&values, |param| (param == y).then_some(0));
    /// assert_eq!(residual.range(&[Interval::point(1.0)]), Interval::new(2.0, 10.0));
    /// ```
    ///
    /// # Panics
    /// If it reads a parameter that is not given and is beyond the end of `values`.
    pub fn residual(&self, values: &[Interval], given: impl Fn(ParamId) -> Option<usize>) -> Residual {
        let mut steps: Vec<Step> = Vec::new();
        // Where the steps begin that make what is on the stack.
        let mut begins: Vec<usize> = Vec::new();
        let mut depth = 0;
        for op in self.program() {
            let count = op.arity();
            let first = begins.len() - count;
            let begin = begins.get(first).copied().unwrap_or(steps.len());
            let step = match *op {
                Op::Constant(value) => Step::Known(Interval::point(value)),
                Op::Param(param) => {
                    given(param).map_or_else(|| Step::Known(values[param.index()]), Step::Given)
                }
                Op::Unary(operator) => Step::Unary(operator),
                Op::Binary(operator) => Step::Binary(operator),
                Op::Call(function, _) => Step::Call(function, count),
            };
            let known = |step: &Step| if let Step::Known(range) = step { Some(*range) } else { None };
            // Of more steps than arguments, some are not known: no look at them, or long expressions took the square of it.
            let few = count > 0 && steps.len() - begin == count;
            let args = few.then(|| steps[begin..].iter().map(known).collect::<Option<Vec<_>>>()).flatten();
            match args {
                Some(args) => {
                    steps.truncate(begin);
                    steps.push(Step::Known(step.range(&args, &[])));
                }
                None => steps.push(step),
            }
            begins.truncate(first);
            begins.push(begin);
            depth = depth.max(begins.len());
        }
        Residual { steps: steps.into(), depth }
    }
}

impl Residual {
    /// What the [range](Expr::range) of the expression is with these intervals.
    ///
    /// # Panics
    /// If one is missing.
    pub fn range(&self, given: &[Interval]) -> Interval {
        const FEW: usize = 8;
        match *self.steps {
            [Step::Known(range)] => range,
            [Step::Given(place)] => given[place],
            _ if self.depth <= FEW => self.run(given, &mut [Interval::EMPTY; FEW]),
            _ => self.run(given, &mut vec![Interval::EMPTY; self.depth]),
        }
    }

    fn run(&self, given: &[Interval], stack: &mut [Interval]) -> Interval {
        let mut top = 0;
        for step in &*self.steps {
            let from = top - step.arity();
            stack[from] = step.range(&stack[from..top], given);
            top = from + 1;
        }
        stack[0]
    }

    /// The memory that it takes, in bytes.
    pub fn bytes(&self) -> usize {
        size_of_val(self) + size_of_val(&*self.steps)
    }
}

impl Step {
    fn arity(self) -> usize {
        match self {
            Self::Known(_) | Self::Given(_) => 0,
            Self::Unary(_) => 1,
            Self::Binary(_) => 2,
            Self::Call(_, count) => count,
        }
    }

    fn range(self, args: &[Interval], given: &[Interval]) -> Interval {
        match self {
            Self::Known(range) => range,
            Self::Given(place) => given[place],
            Self::Unary(operator) => operator.range(args[0]),
            Self::Binary(operator) => operator.range(args[0], args[1]),
            Self::Call(function, _) => function.range(args),
        }
    }
}
