//! What goes wrong in an evaluation, told to the author of the file: where, with which values, and the probable cause.

use csg_graph::{AttributeTerm, EvalError, Fault, Number};

use crate::number::{NOT_A_NUMBER, values};
use crate::{Diagnostic, SourceMap, Span};

/// Tells where and why an evaluation failed.
pub(crate) fn evaluation(sources: &SourceMap, error: &EvalError) -> Diagnostic {
    let at =
        Evaluation { span: sources.place(&error.at), name: sources.name(&error.at), values: &error.values };
    match &error.fault {
        Fault::NoSuchRule { value, rules } => at.no_such_rule(*value, *rules),
        Fault::Unset(param) => at.unset(param),
        Fault::NotANumber => at.not_a_number(),
        Fault::Infinite(_) => at.infinite(),
        Fault::Singular(call) => at.singular(call),
        Fault::OutOfRange { term, value } => at.out_of_range(*term, *value),
        fault @ Fault::Nothing => at
            .error(fault.to_string(), "comes to no primitive")
            .help("is there a rule that ends it, and does its selection function ever take that?"),
        fault @ Fault::Slow => at.error(fault.to_string(), "still not as small as a pixel").help(
            "scale each part by less, as `uscale(0.9)`, or count its levels with a parameter and end it by a rule",
        ),
        fault @ Fault::Crowded => at.error(fault.to_string(), "one of the parts").help(
            "each level of copies that overlap doubles what a ray meets: make them smaller, or move them apart",
        ),
        fault @ Fault::Bottomless => at.error(fault.to_string(), "has itself for an operand").help(
            "it is looked into until it is too small to be seen: scale it by less than 1, or end it by a rule",
        ),
        fault @ Fault::TooLarge { .. } => at.error(fault.to_string(), "too large from here upwards").help(at.factors("below")),
        fault @ Fault::TooSmall { .. } => at.error(fault.to_string(), "too small from here upwards").help(at.factors("above")),
        fault @ Fault::TooFar { .. } => at
            .error(fault.to_string(), "too far away from here upwards")
            .help("what is so small beside its distance is a point: move it less, or make it larger"),
        fault => at.error(fault.to_string(), "no such solid"),
    }
}

/// An evaluation that failed.
struct Evaluation<'a> {
    span: Span,
    /// What was evaluated.
    name: &'a str,
    /// The parameters that were read.
    values: &'a [(String, f64)],
}

impl Evaluation<'_> {
    /// An error that shows the values of the parameters, or else something that holds without any.
    fn error(&self, message: impl Into<String>, alone: &str) -> Diagnostic {
        let label = values(self.values).unwrap_or_else(|| alone.to_owned());
        Diagnostic::error(self.span, message).label(label)
    }

    fn no_such_rule(&self, value: f64, rules: usize) -> Diagnostic {
        let name = self.name;
        let range = match rules {
            1 => "its only rule is 1".to_owned(),
            _ => format!("its rules are 1 to {rules}"),
        };
        let shown = Number(value);
        let help = if value.fract() != 0.0 {
            "a rule number is a whole number; `floor`, `ceil` and `round` make one"
        } else if value == 0.0 {
            "rules are counted from 1, and a condition that is false is 0; choose with `if(condition, 2, 1)`"
        } else if value < 0.0 {
            "rules are counted from 1; has a parameter passed its end? `clamp` keeps a value in range"
        } else {
            &format!("is rule {shown} of `{name}` missing, or does the selection count from elsewhere?")
        };
        let message = format!("the selection function of `{name}` gives {shown}, and {range}");
        self.error(message, &format!("always {shown}")).help(help)
    }

    fn unset(&self, param: &str) -> Diagnostic {
        Diagnostic::error(self.span, format!("parameter `{param}` is read but was never set"))
            .label(format!("`{param}` has no value here"))
            .help(format!(
                "give it an initial value between the first braces, or set it on every way here: `{{{param} = …}}`"
            ))
    }

    fn not_a_number(&self) -> Diagnostic {
        self.error(format!("a value of `{}` is not a number", self.name), "not a number").help(NOT_A_NUMBER)
    }

    fn infinite(&self) -> Diagnostic {
        let zero = self.values.iter().find(|(_, value)| *value == 0.0);
        let infinite = self.values.iter().find(|(_, value)| value.is_infinite());
        let help = match (zero, infinite) {
            (Some((zero, _)), _) => format!("was something divided by `{zero}`, which is 0 here?"),
            (_, Some((param, _))) => {
                format!("`{param}` is infinite itself: was something divided by zero to get it?")
            }
            _ => "was something divided by zero?".to_owned(),
        };
        self.error(format!("an argument of `{}` is infinite", self.name), "infinite").help(help)
    }

    /// What to do about a size that gets out of hand, where factors should be on that side of 1.
    fn factors(&self, side: &str) -> String {
        let name = self.name;
        if self.values.is_empty() {
            format!("it is `{name}` that makes it so: has a number of it a digit or an exponent too many?")
        } else {
            format!(
                "with these values `{name}` makes it so, as each level multiplies the sizes below it: is a factor {side} 1 meant, or \
                 is the recursion to end earlier?"
            )
        }
    }

    fn singular(&self, call: &str) -> Diagnostic {
        const SHOWN: usize = 40;
        let name = self.name;
        let call = if call.len() <= SHOWN { call } else { name };
        match name {
            "rot" => self.error("the axis of `rot` has no direction", "cannot be turned about").help(
                "the axis is a vector from the origin, such as (0, 0, 1); its length does not matter, but cannot be 0",
            ),
            "matrix" => self
                .error("the transformation `matrix` is singular", "flattens every solid")
                .help("rows that depend on each other leave no solid, and no ray finds its way back"),
            _ => self
                .error(format!("the transformation `{call}` is singular"), "flattens every solid")
                .help("a factor of 0 leaves no solid, and no ray finds its way back; nor can one too near to 0 be undone"),
        }
    }

    fn out_of_range(&self, term: AttributeTerm, value: f64) -> Diagnostic {
        let (least, most) = term.range().into_inner();
        let message = format!("`{}` of `{}` is {}", term.name(), self.name, Number(value));
        match term {
            AttributeTerm::Red | AttributeTerm::Green | AttributeTerm::Blue if value > most => self
                .error(format!("{message}, which is not from {least} to {most}"), "out of range")
                .help(
                    "it is the part of the light that the surface gives back, at most all of it: 1, not 255; `clamp(…, 0, 1)` \
                     keeps a value in range, and light of its own is `material(emission = …)`",
                ),
            _ if most.is_finite() => self
                .error(format!("{message}, which is not from {least} to {most}"), "out of range")
                .help(format!("`clamp(…, {least}, {most})` keeps a value in range")),
            AttributeTerm::Ior => self.error(format!("{message}, which is less than {least}"), "too small").help(
                "it is how many times as fast light is outside: 1.33 for water, 1.5 for glass, 2.4 for diamond",
            ),
            _ => self
                .error(format!("{message}, which is negative"), "negative")
                .help("there is no less than 0 of it; `max(0, …)` keeps a value from falling below"),
        }
    }
}
