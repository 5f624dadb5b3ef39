//! Reading a scene, and reporting its mistakes where they are.

use std::fmt::Display;
use std::fs::File;
use std::io::{self, ErrorKind, Read};
use std::path::{Path, PathBuf};

use csg_graph::{Analysis, EvalError, Fault, Limits, Node, Place, State, StatesError, SymbolState};
use csg_graph_bounds::{Aabb, BoundsError, Envelopes};
use csg_graph_grammar::{Diagnostic, Lowered, Override, Scene, Severity};

use crate::args::{SceneArgs, Setting};
use crate::{Failure, bounds, output, say};

/// Nodes that are looked at for each face of the box that the camera frames, where the states are too many to be listed.
const FACE_STEPS: usize = 2000;

/// States that are looked at for one that leads to nothing, where they are too many to be listed.
const LOOKED_AT: usize = 100_000;

/// The most bytes that a file may have.
const LARGEST: u64 = 1 << 26;

/// The options that limit how many states are listed.
pub(crate) const MAX_STATES: &str = "--max-states";
pub(crate) const MEMORY: &str = "--memory";

/// The most diagnostics that are shown.
const SHOWN: usize = 100;

/// A scene that has no mistakes so far, with the text that later messages point into.
pub(crate) struct Loaded {
    pub(crate) scene: Scene,
    /// The file as it was named.
    pub(crate) name: String,
    pub(crate) limits: Limits,
    path: PathBuf,
    source: String,
    /// What sets parameters from outside.
    settings: Vec<Setting>,
}

/// Reads a scene and translates it; mistakes and warnings are reported.
pub(crate) fn load(args: &SceneArgs) -> Result<Loaded, Failure> {
    let source = read(&args.scene)?;
    let name = args.scene.display().to_string();
    let settings = args.assignments()?;
    let lowered = lower(&source, &settings).map_err(|diagnostics| {
        report(&name, &source, &diagnostics);
        mistakes(&args.scene, &diagnostics)
    })?;
    report(&name, &source, &lowered.warnings);
    let mut limits = Limits::default();
    limits.states = args.max_states;
    let path = args.scene.clone();
    Ok(Loaded { scene: lowered.scene, limits, path, name, source, settings })
}

fn lower(source: &str, settings: &[Setting]) -> Result<Lowered, Vec<Diagnostic>> {
    let overrides = settings.iter().map(|setting| Override::parse_from(setting.option, &setting.text));
    csg_graph_grammar::load(source, &overrides.collect::<Result<Vec<_>, _>>()?)
}

impl Loaded {
    /// The same scene at another value of a sweep, or the mistakes that this makes, which are not reported.
    pub(crate) fn varied(&self, name: &str, value: impl Display) -> Result<Self, Vec<Diagnostic>> {
        let mut settings = self.settings.clone();
        settings.retain(|setting| setting.name() != name);
        settings.push(Setting { option: "--sweep", text: format!("{name}={value}") });
        let scene = lower(&self.source, &settings)?.scene;
        let (path, source) = (self.path.clone(), self.source.clone());
        Ok(Self { scene, name: self.name.clone(), limits: self.limits, path, source, settings })
    }

    /// The parameters that were set from outside, each as `NAME=EXPR`.
    pub(crate) fn set(&self) -> impl Iterator<Item = &str> {
        self.settings.iter().map(|setting| setting.text.as_str())
    }

    /// The options of a command that set the same parameters but one, each with a space before it.
    pub(crate) fn options_without(&self, name: &str) -> String {
        let others = self.settings.iter().filter(|setting| setting.name() != name);
        others.map(|setting| format!(" --set {}", setting.text.replace(' ', ""))).collect()
    }

    /// Reports mistakes.
    pub(crate) fn mistakes(&self, diagnostics: &[Diagnostic]) -> Failure {
        report(&self.name, &self.source, diagnostics);
        mistakes(&self.path, diagnostics)
    }

    /// The text of the file.
    pub(crate) fn source(&self) -> &str {
        &self.source
    }

    /// Whether a path leads to the scene's file.
    pub(crate) fn is_file(&self, path: &Path) -> bool {
        output::is_same(&self.path, path)
    }

    /// The name of the file without its folder.
    pub(crate) fn file_name(&self) -> String {
        self.path.file_name().unwrap_or(self.path.as_os_str()).to_string_lossy().into_owned()
    }

    /// Analyses the graph; what is wrong with it is reported. None for a recursion that never ends, and shrinks to a solid.
    pub(crate) fn analyse_unless_endless(&self) -> Result<Option<Analysis>, Failure> {
        match self.scene.graph.analyse(&self.limits) {
            Ok(analysis) => Ok(Some(analysis)),
            Err(StatesError::Endless { .. }) => {
                // The rough boxes are enough to tell that it shrinks, and quickly found.
                bounds::endless_boxes(self, &self.bounds_limits().with_gap(1.0)).map(|_| None)
            }
            Err(error) => Err(self.failure_to_list(&error)),
        }
    }

    /// Bounds for states that are too many to be listed, of which an option would allow more. A recursion that leads to
    /// nothing is a mistake among these, too, as far as it can be known.
    pub(crate) fn envelopes(&self, option: &str) -> Result<Envelopes, Failure> {
        const ANYWHERE: &str =
            "it has more states than are listed, and without a list its parts may be anywhere";
        let envelopes = Envelopes::new(self.scene.graph.clone(), &self.bounds_limits());
        if let Some(state) = envelopes.leads_nowhere(LOOKED_AT) {
            return Err(self.failure_at(&state, Fault::Nothing));
        }
        let reason = match envelopes.of(&self.scene.graph.root_state()) {
            Ok(root) if root.aabb().is_bounded() => return Ok(envelopes),
            Ok(_) => ANYWHERE.to_owned(),
            Err(BoundsError::Endless { cycle, round }) => {
                let symbol = cycle.first().map_or("it", String::as_str);
                format!("{ANYWHERE}: {symbol} leads back to itself and {round}")
            }
            Err(error) => return Err(bounds::failure(self, error)),
        };
        // With as many as are allowed, there may still be too many.
        let more = if self.report_unlisted() && option != MAX_STATES {
            format!("{option} and {MAX_STATES}, both of them")
        } else {
            option.to_owned()
        };
        Err(self.refused(format!("{reason}; raise {more}")))
    }

    /// The box of a scene with envelopes, about as large as a picture of it has to be.
    pub(crate) fn refined_box(&self, envelopes: &Envelopes) -> Result<Aabb, Failure> {
        let root = envelopes.refined_box(&self.scene.graph.root_state(), FACE_STEPS);
        root.map_err(|error| bounds::failure(self, error))
    }

    /// Points at a recursion that never ends, or at that for which there are too many states, if there is one.
    pub(crate) fn report_unlisted(&self) -> bool {
        match self.scene.graph.analyse(&self.limits) {
            Err(error @ (StatesError::Endless { .. } | StatesError::TooMany { .. })) => {
                report(&self.name, &self.source, &self.explained(&error, MAX_STATES));
                true
            }
            _ => false,
        }
    }

    /// Says what may be a mistake about states that are not listed, though the solid can be traced: too many of them where
    /// nothing is random, or a recursion that never ends though there is a selection function, which was probably to end it.
    pub(crate) fn doubt(&self, unlisted: &StatesError, option: &str) {
        let graph = &self.scene.graph;
        let is_random = |node: &Node| node.exprs().iter().any(|expr| expr.is_erratic());
        let selects = |state: &SymbolState| matches!(graph.node(state.node), Node::Symbol(symbol) if symbol.selection.is_some());
        let is_doubtful = match unlisted {
            StatesError::TooMany { .. } => !graph.nodes().any(|(_, node)| is_random(node)),
            StatesError::Endless { path } => path.iter().any(selects),
            _ => false,
        };
        if is_doubtful {
            let mut warnings = self.explained(unlisted, option);
            warnings.iter_mut().for_each(|doubt| doubt.severity = Severity::Warning);
            report(&self.name, &self.source, &warnings);
        }
    }

    /// Reports why the states cannot be listed.
    pub(crate) fn failure(&self, error: &StatesError) -> Failure {
        self.mistakes(&self.explained(error, MAX_STATES))
    }

    /// Reports what is wrong with the solid of a state.
    pub(crate) fn failure_at(&self, state: &State, fault: Fault) -> Failure {
        let graph = &self.scene.graph;
        let at = Place { node: state.node(), expr: None, label: graph.node_name(state.node()) };
        let error = EvalError { at, fault, values: graph.live_values(state) };
        self.failure(&error.into())
    }

    /// [`Self::failure`] for who wants more than can be said without a list. No limit is enough for what leads to nothing.
    pub(crate) fn failure_to_list(&self, error: &StatesError) -> Failure {
        if let StatesError::TooMany { .. } = error {
            let envelopes = Envelopes::new(self.scene.graph.clone(), &self.bounds_limits());
            if let Some(state) = envelopes.leads_nowhere(LOOKED_AT) {
                return self.failure_at(&state, Fault::Nothing);
            }
        }
        let or_else = "; without a list, `pcsg check` tells the box of the whole";
        self.mistakes(&self.explained(error, &format!("{MAX_STATES}{or_else}")))
    }

    /// Why the states cannot be listed. Of those that are too many, also what can be done.
    fn explained(&self, error: &StatesError, by: &str) -> Vec<Diagnostic> {
        let mut diagnostics = self.scene.explain(error);
        if let StatesError::TooMany { .. } = error {
            for help in diagnostics.iter_mut().filter_map(|diagnostic| diagnostic.help.as_mut()) {
                help.push_str(" with ");
                help.push_str(by);
            }
        }
        diagnostics
    }

    /// The limits for boxes: those of the analysis, which has listed the states before.
    pub(crate) fn bounds_limits(&self) -> csg_graph_bounds::Limits {
        csg_graph_bounds::Limits::default().with_states(self.limits.states)
    }

    /// For what is no mistake in the file.
    pub(crate) fn refused(&self, reason: impl ToString) -> Failure {
        Failure::refused(&self.path, reason)
    }
}

/// Reads a file as text.
pub(crate) fn read(path: &Path) -> Result<String, Failure> {
    let all = |path: &Path| -> io::Result<Vec<u8>> {
        let mut bytes = Vec::new();
        File::open(path)?.take(LARGEST + 1).read_to_end(&mut bytes)?;
        if bytes.len() as u64 > LARGEST {
            let reason = format!(
                "it has more than {LARGEST} bytes; is it a scene? Even large ones have a few thousand"
            );
            return Err(io::Error::other(reason));
        }
        Ok(bytes)
    };
    let bytes = all(path).map_err(|error| {
        let meant = path.with_extension("pcsg");
        let error = match error.kind() {
            ErrorKind::NotFound if meant.is_file() => {
                io::Error::other(format!("there is no such file; did you mean {}?", meant.display()))
            }
            ErrorKind::NotFound => io::Error::other("there is no such file"),
            _ => error,
        };
        Failure::file(path, "read it")(error)
    })?;
    let name = path.display().to_string();
    csg_graph_grammar::decode(&name, &bytes).map(str::to_owned).map_err(|diagnostic| {
        report(&name, "", std::slice::from_ref(&diagnostic));
        mistakes(path, &[*diagnostic])
    })
}

/// Writes diagnostics to standard error.
pub(crate) fn report(name: &str, source: &str, diagnostics: &[Diagnostic]) {
    for diagnostic in diagnostics.iter().take(SHOWN) {
        say(format_args!("{}\n", diagnostic.render(name, source, true)));
    }
    if let more @ 1.. = diagnostics.len().saturating_sub(SHOWN) {
        say(format_args!("and {more} more\n"));
    }
}

/// The failure that ends a report.
pub(crate) fn mistakes(path: &Path, diagnostics: &[Diagnostic]) -> Failure {
    let count = diagnostics.iter().filter(|diagnostic| diagnostic.is_error()).count();
    Failure::Mistakes { scene: path.to_owned(), count }
}
