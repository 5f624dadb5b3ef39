//! Reading a scene, and reporting its mistakes where they are.

use std::fs;
use std::path::{Path, PathBuf};

use csg_graph::{Analysis, Limits, StatesError};
use csg_graph_grammar::{Diagnostic, Override, Scene};

use crate::args::SceneArgs;
use crate::{Failure, say};

/// A scene that has no mistakes so far, with the text that later messages point into.
pub(crate) struct Loaded {
    pub(crate) scene: Scene,
    /// The file as it was named.
    pub(crate) name: String,
    pub(crate) limits: Limits,
    path: PathBuf,
    source: String,
}

/// Reads a scene and translates it; mistakes and warnings are reported.
pub(crate) fn load(args: &SceneArgs) -> Result<Loaded, Failure> {
    let source = read(&args.scene)?;
    let name = args.scene.display().to_string();
    let mistakes = |mut diagnostics: Vec<Diagnostic>| {
        let foreign = diagnostics.iter_mut().filter_map(|diagnostic| diagnostic.excerpt.as_mut());
        foreign.for_each(|excerpt| excerpt.name = "--set".to_owned());
        report(&name, &source, &diagnostics);
        mistakes(&args.scene, &diagnostics)
    };
    let overrides = args.set.iter().map(|set| Override::parse(set)).collect::<Result<Vec<_>, _>>();
    let lowered = csg_graph_grammar::load(&source, &overrides.map_err(mistakes)?).map_err(mistakes)?;
    report(&name, &source, &lowered.warnings);
    let mut limits = Limits::default();
    limits.states = args.max_states;
    Ok(Loaded { scene: lowered.scene, limits, path: args.scene.clone(), name, source })
}

impl Loaded {
    /// Analyses the graph; what is wrong with it is reported.
    pub(crate) fn analyse(&self) -> Result<Analysis, Failure> {
        self.scene.graph.analyse(&self.limits).map_err(|error| self.failure(&error))
    }

    /// Reports why the states cannot be listed.
    pub(crate) fn failure(&self, error: &StatesError) -> Failure {
        let mut diagnostic = self.scene.explain(error);
        if let (StatesError::TooMany { .. }, Some(help)) = (error, &mut diagnostic.help) {
            help.push_str(" with --max-states");
        }
        let diagnostics = [diagnostic];
        report(&self.name, &self.source, &diagnostics);
        mistakes(&self.path, &diagnostics)
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
    let bytes = fs::read(path).map_err(Failure::file(path, "read it"))?;
    let name = path.display().to_string();
    csg_graph_grammar::decode(&name, &bytes).map(str::to_owned).map_err(|diagnostic| {
        report(&name, "", std::slice::from_ref(&diagnostic));
        mistakes(path, &[*diagnostic])
    })
}

/// Writes diagnostics to standard error.
pub(crate) fn report(name: &str, source: &str, diagnostics: &[Diagnostic]) {
    for diagnostic in diagnostics {
        say(format_args!("{}\n", diagnostic.render(name, source, true)));
    }
}

/// The failure that ends a report.
pub(crate) fn mistakes(path: &Path, diagnostics: &[Diagnostic]) -> Failure {
    let count = diagnostics.iter().filter(|diagnostic| diagnostic.is_error()).count();
    Failure::Mistakes { scene: path.to_owned(), count }
}
