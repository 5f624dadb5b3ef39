//! Arithmetic expressions over parameters.
//!
//! An expression is a postfix program for a stack of numbers, so that evaluating, copying and inspecting it are loops,
//! however deep it was nested. Truth is a number: 0 is false, everything else true.
//!
//! *Not a number* marks what has no value (an unset parameter, 0/0): it is contagious, in comparisons too, and only a
//! branch that `if`, `&&` or `||` does not take stops it. Whoever uses a result must refuse it.

use std::ops::{Add, Div, Mul, Neg, Rem, Sub};

use crate::function::HIDDEN;
use crate::{Binary, Env, Function, Interval, Number, ParamId, Unary};

/// An arithmetic expression over parameters.
///
/// ```
/// use csg_graph::{Expr, GraphBuilder};
///
/// let mut builder = GraphBuilder::new();
/// let cnt = builder.param("cnt", 8.0);
/// let half = Expr::from(cnt) / 2.0 - 1.0;
/// assert_eq!(half.evaluate(builder.initial()), 3.0);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Expr {
    program: Vec<Op>,
}

/// One step of the postfix program.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Op {
    Constant(f64),
    Param(ParamId),
    Unary(Unary),
    Binary(Binary),
    /// A function of so many arguments, the [hidden](HIDDEN) ones included.
    Call(Function, u32),
}

impl Expr {
    /// `operator a`
    #[must_use]
    pub fn unary(operator: Unary, a: impl Into<Self>) -> Self {
        let mut program = a.into().program;
        program.push(Op::Unary(operator));
        Self { program }
    }

    /// `a operator b`
    #[must_use]
    pub fn binary(operator: Binary, a: impl Into<Self>, b: impl Into<Self>) -> Self {
        let mut program = a.into().program;
        program.extend(b.into().program);
        program.push(Op::Binary(operator));
        Self { program }
    }

    /// `function(arguments…)`
    ///
    /// # Panics
    /// If there are more or fewer arguments than the function takes, or it is [random](Function::is_random).
    #[must_use]
    pub fn call(function: Function, arguments: impl IntoIterator<Item = Self>) -> Self {
        assert!(!function.is_random(), "{} needs a seed and a site", function.name());
        Self::apply(function, [], arguments)
    }

    /// `function(arguments…)` of a [random](Function::is_random) function.
    ///
    /// The number is a function of the arguments, the seed, and the site, which tells apart the numbers that one seed
    /// gives. A draw at the same site from the same seed is the same draw.
    ///
    /// ```
    /// use csg_graph::{Expr, Function, GraphBuilder};
    ///
    /// let mut builder = GraphBuilder::new();
    /// let seed = builder.param("seed", 7.0);
    /// let width = |site| Expr::draw(Function::Rand, seed, site, [1.0.into(), 2.0.into()]);
    /// let [first, second] = [width(1), width(2)].map(|expr| expr.evaluate(builder.initial()));
    /// assert!((1.0..2.0).contains(&first) && (1.0..2.0).contains(&second) && first != second);
    /// assert_eq!(width(1).evaluate(builder.initial()), first);
    /// ```
    ///
    /// # Panics
    /// If there are more or fewer arguments than the function takes, or it is not random.
    #[must_use]
    pub fn draw(
        function: Function,
        seed: impl Into<Self>,
        site: u32,
        arguments: impl IntoIterator<Item = Self>,
    ) -> Self {
        assert!(function.is_random(), "{} draws nothing", function.name());
        Self::apply(function, [seed.into(), f64::from(site).into()], arguments)
    }

    /// `derive(seed, position)`: what a C-node gives the seed, so that what is below draws other numbers than what is above
    /// or beside it. [`GraphBuilder::reseed`](crate::GraphBuilder::reseed) makes that node.
    #[must_use]
    pub fn derive(seed: impl Into<Self>, position: u32) -> Self {
        Self::call(Function::Derive, [seed.into(), f64::from(position).into()])
    }

    fn apply<const N: usize>(
        function: Function,
        hidden: [Self; N],
        arguments: impl IntoIterator<Item = Self>,
    ) -> Self {
        let mut program = Vec::new();
        let mut count = 0_u32;
        for argument in hidden.into_iter().chain(arguments) {
            program.extend(argument.program);
            count += 1;
        }
        assert!(function.arity().contains(&(count as usize - N)), "arguments of {}", function.signature());
        program.push(Op::Call(function, count));
        Self { program }
    }

    /// `if(condition, then, otherwise)`
    #[must_use]
    pub fn choose(condition: impl Into<Self>, then: impl Into<Self>, otherwise: impl Into<Self>) -> Self {
        Self::call(Function::If, [condition.into(), then.into(), otherwise.into()])
    }

    /// `self > other`, the usual guard of a recursion.
    #[must_use]
    pub fn gt(self, other: impl Into<Self>) -> Self {
        Self::binary(Binary::Greater, self, other)
    }

    /// The value in `env`; not a number where it has none (see the module's head).
    pub fn evaluate(&self, env: &Env) -> f64 {
        if let [Op::Constant(value)] = self.program[..] {
            return value;
        }
        self.fold(0.0, |op, args| match op {
            Op::Constant(value) => value,
            Op::Param(param) => env.values()[param.index()],
            Op::Unary(operator) => operator.apply(args[0]),
            Op::Binary(operator) => operator.apply(args[0], args[1]),
            Op::Call(function, _) => function.apply(args),
        })
    }

    /// All numbers that it may give while each parameter is anywhere in its interval, which stands at the parameter's
    /// index: [`evaluate`](Self::evaluate) gives one of these, or what is not a number.
    ///
    /// The range may be larger than it has to be: where a parameter is read twice, both are taken to vary on their own.
    /// Where all intervals are points, so is the range, and is the value.
    ///
    /// # Panics
    /// If it reads a parameter beyond the end of `values`.
    pub fn range(&self, values: &[Interval]) -> Interval {
        self.fold(Interval::EMPTY, |op, args| match op {
            Op::Constant(value) => Interval::point(value),
            Op::Param(param) => values[param.index()],
            Op::Unary(operator) => operator.range(args[0]),
            Op::Binary(operator) => operator.range(args[0], args[1]),
            Op::Call(function, _) => function.range(args),
        })
    }

    /// Runs the program on a stack, given what each step makes of its arguments. Allocates nothing for short ones.
    fn fold<T: Copy>(&self, blank: T, step: impl Fn(Op, &[T]) -> T) -> T {
        const SHORT: usize = 24;
        let mut few = [blank; SHORT];
        let mut many = Vec::new();
        // No stack is deeper than the program is long.
        let stack = if self.program.len() <= SHORT {
            &mut few[..]
        } else {
            many.resize(self.program.len(), blank);
            &mut many[..]
        };
        let mut top = 0;
        for op in &self.program {
            let from = top - op.arity();
            stack[from] = step(*op, &stack[from..top]);
            top = from + 1;
        }
        stack[0]
    }

    pub(crate) fn program(&self) -> &[Op] {
        &self.program
    }

    /// The parameters that it reads, in the order of reading, with repetitions.
    pub fn params(&self) -> impl Iterator<Item = ParamId> + '_ {
        self.program.iter().filter_map(|op| match op {
            Op::Param(param) => Some(*param),
            _ => None,
        })
    }

    /// The parameters that its [range](Self::range) depends on, with repetitions: not those of which only the seed of a
    /// random number is made, or what a hash or noise is of.
    pub fn range_params(&self) -> Vec<ParamId> {
        let mut params = Vec::new();
        // Backwards, with whether the range depends on the values that are yet to be found, the next one last.
        let mut wanted = vec![true];
        for op in self.program.iter().rev() {
            let matters = wanted.pop().unwrap_or(false);
            match *op {
                Op::Param(param) if matters => params.push(param),
                Op::Call(function, count) => {
                    wanted.extend((0..count as usize).map(|index| matters && function.ranges_over(index)));
                }
                _ => wanted.extend(std::iter::repeat_n(matters, op.arity())),
            }
        }
        params
    }

    /// Whether it draws, hashes or makes noise, so that nothing but its range is foreseen.
    pub fn is_erratic(&self) -> bool {
        self.program.iter().any(|op| matches!(op, Op::Call(function, _) if function.is_erratic()))
    }

    /// The expression as the language writes it, with only the parentheses that it needs. The seeds and sites of random
    /// functions are not part of the language.
    pub fn to_text<'a>(&self, param_name: impl Fn(ParamId) -> &'a str) -> String {
        // Each entry is a text and how tightly its outermost operator binds.
        let mut stack: Vec<(String, u8)> = Vec::new();
        for op in &self.program {
            let args = stack.split_off(stack.len() - op.arity());
            let strength = op.strength();
            let wrapped = |index: usize, least: u8| {
                let (text, strength) = &args[index];
                if *strength < least { format!("({text})") } else { text.clone() }
            };
            let text = match op {
                Op::Constant(value) => Number(*value).to_string(),
                Op::Param(param) => param_name(*param).to_owned(),
                Op::Unary(operator) => format!("{}{}", operator.symbol(), wrapped(0, strength)),
                Op::Binary(Binary::Power) => format!("{}^{}", wrapped(0, strength + 1), wrapped(1, strength)),
                Op::Binary(operator) => {
                    format!("{} {} {}", wrapped(0, strength), operator.symbol(), wrapped(1, strength + 1))
                }
                Op::Call(function, _) => {
                    let hidden = if function.is_random() { HIDDEN } else { 0 };
                    let list: Vec<_> = args.into_iter().skip(hidden).map(|(text, _)| text).collect();
                    format!("{}({})", function.name(), list.join(", "))
                }
            };
            stack.push((text, strength));
        }
        stack.pop().map_or_else(String::new, |(text, _)| text)
    }
}

impl Op {
    pub(crate) fn arity(self) -> usize {
        match self {
            Self::Constant(_) | Self::Param(_) => 0,
            Self::Unary(_) => 1,
            Self::Binary(_) => 2,
            Self::Call(_, count) => count as usize,
        }
    }

    /// How tightly it binds in the language; what is no operator is never torn apart.
    fn strength(self) -> u8 {
        match self {
            Self::Constant(value) if value < 0.0 => Unary::Negate.strength(),
            Self::Constant(_) | Self::Param(_) | Self::Call(..) => u8::MAX,
            Self::Unary(operator) => operator.strength(),
            Self::Binary(operator) => operator.strength(),
        }
    }
}

impl From<f64> for Expr {
    fn from(value: f64) -> Self {
        Self { program: vec![Op::Constant(value)] }
    }
}

impl From<ParamId> for Expr {
    fn from(param: ParamId) -> Self {
        Self { program: vec![Op::Param(param)] }
    }
}

macro_rules! operator {
    ($trait:ident, $method:ident, $operator:expr) => {
        impl<T: Into<Expr>> $trait<T> for Expr {
            type Output = Expr;
            fn $method(self, other: T) -> Expr {
                Expr::binary($operator, self, other)
            }
        }
    };
}

operator!(Add, add, Binary::Add);
operator!(Sub, sub, Binary::Subtract);
operator!(Mul, mul, Binary::Multiply);
operator!(Div, div, Binary::Divide);
operator!(Rem, rem, Binary::Remainder);

impl Neg for Expr {
    type Output = Self;
    fn neg(self) -> Self {
        Self::unary(Unary::Negate, self)
    }
}
