//! Mistakes: each is told once, where it is, with a guess. (`tests/broken` of the repository has one file a mistake.)

mod common;

use csg_graph_grammar::{Diagnostic, Integrator, LightSource, Override, decode, load, parse, print};
use proptest::prelude::*;

fn errors(source: &str) -> Vec<Diagnostic> {
    load(source, &[]).expect_err("a mistake")
}

fn told(source: &str) -> Vec<String> {
    errors(source)
        .iter()
        .map(|report| {
            let (line, column) = report.position(source);
            format!("{line}:{column} {}", report.message)
        })
        .collect()
}

#[test]
fn independent_mistakes_are_each_told_once() {
    let source = "\
{ n = 3, r = 0.5; } TREE
TREE if(n > 0, 2, 1)
1: TREE -> spheer | spheer
2: TREE -> sphere | {n = n - 1} move(0, 1) uscale(r) TREE
3 TREE -> (cube | cone
leaf = color(1, 0) scale(1, 2 3) cube)
camera { eyes = (1, 2, 3); }
";
    assert_eq!(
        told(source),
        [
            "1:8 expected `;`, found `,`",
            "3:12 unknown solid `spheer`",
            "4:33 `move` takes 3 arguments, not 2",
            "5:3 expected `:` after the number of the rule, found `TREE`",
            "5:11 this `(` is not closed",
            "6:8 `color` takes 3 arguments, not 2",
            "6:31 expected `,` or `)`, found `3`",
            "6:38 this `)` closes nothing",
            "7:10 `camera` has no field `eyes`",
        ]
    );
}

#[test]
fn rendered_like_rustc() {
    let source =
        "{ cnt = 3; } A\nA if(cnt > 0, 2, 1)\n1: A -> sphere\n2: A -> cube | {cnt = ctn - 1} uscale(0.5) A\n";
    let report = &errors(source)[0];
    assert_eq!(
        report.render("a.pcsg", source, false),
        "\
error: unknown parameter `ctn`
 --> a.pcsg:4:23
  |
4 | 2: A -> cube | {cnt = ctn - 1} uscale(0.5) A
  |                       ^^^ unknown
  |
  = help: did you mean `cnt`?"
    );
    assert!(report.render("a.pcsg", source, true).contains("\u{1b}["));
}

#[test]
fn lines_far_apart_are_both_shown() {
    let source = format!("{{ n = 3;\n{} n = 4; }} uscale(n) sphere", "\n".repeat(20));
    let text = errors(&source)[0].render("a.pcsg", &source, false);
    assert!(text.contains("the first") && text.contains("the second"), "{text}");
}

#[test]
fn overrides_are_told_with_their_own_text() {
    let source = "{ cnt = 3; fBR = 1 / cnt; } uscale(fBR) sphere";
    let report = |text: &str| match Override::parse(text) {
        Ok(given) => load(source, &[given]).expect_err("a mistake")[0].render("a.pcsg", source, false),
        Err(reports) => reports[0].render("a.pcsg", source, false),
    };
    assert!(report("ctn = 4").contains("the file has no parameter `ctn`"));
    assert!(report("ctn = 4").contains("1 | ctn = 4\n"));
    assert!(report("ctn = 4").contains("did you mean `cnt`?"));
    assert!(report("cnt").contains("expected `NAME = EXPRESSION`"));
    assert!(report("cnt = 4 +").contains("expected an expression"));
    assert!(report("cnt = cnt + 1").contains("`cnt` cannot be computed from itself"));
    assert!(report("cnt == 3").contains("`==` compares; to assign, write `=`"));
    assert!(report("cnt = (3").contains("the expression ends too early"));
    assert!(report("cnt = 4 5").contains("expected the end of the expression"));
    assert!(report("cnt = fBR").contains("`fBR` is set further down"));
    assert!(report("cnt = 0 / 0").contains("the initial value of `cnt` is not a number"));
    let last_wins = ["cnt = 5", "cnt = 8"].map(|text| Override::parse(text).unwrap());
    let scene = load(source, &last_wins).unwrap().scene;
    assert_eq!(scene.graph.initial().get(scene.graph.params().nth(1).unwrap()), Some(0.125));
}

#[test]
fn doubts_are_no_errors() {
    let source =
        "{ n = 1; k = 3; _spare = 2; } A\nA -> sphere | {k = k - 1} uscale(0.5) A\nB -> cube\npart = cube";
    let warnings = load(source, &[]).unwrap().warnings;
    let told: Vec<_> = warnings.iter().map(|warning| warning.message.as_str()).collect();
    assert_eq!(
        told,
        [
            "parameter `n` is set and never read",
            "parameter `k` is set and never read",
            "the axiom does not lead to `B`",
            "the axiom does not lead to `part`"
        ]
    );
    let help: Vec<_> = warnings.iter().filter_map(|warning| warning.help.as_deref()).collect();
    assert_eq!(help.len(), 1);
    assert!(help[0].contains("`TREE if(k > 0, 2, 1)`"), "{help:?}");
}

#[test]
fn angles_made_with_pi_are_doubted() {
    let doubts = |source: &str| {
        let warnings = load(source, &[]).unwrap().warnings;
        warnings
            .iter()
            .map(|warning| (warning.message.clone(), warning.position(source).1))
            .collect::<Vec<_>>()
    };
    let doubt = |column| ("an angle is made with `pi`".to_owned(), column);
    assert_eq!(doubts("{} rotz(-(pi / 4)) rot((0, 0, pi), 2 * pi) cube"), [doubt(11), doubt(40)]);
    assert_eq!(doubts("{} move(cos(pi), sin(sin(pi / 2)), 0) cube"), [doubt(13), doubt(26)]);
    // Degrees are made of radians, and areas of lengths.
    assert_eq!(doubts("{ a = 1; } rotz(a * 180 / pi) uscale(pi * a ^ 2) cube"), []);
}

#[test]
fn scene_blocks_are_read_with_the_initial_parameters() {
    let source = "{ n = 2; } sphere
        camera { eye = (n, -n*4, 1); fov = 30 + n }
        light { position = (1, 2, 3); shadow = 0; }
        light { direction = (0, 0, -n); color = (2, 1, 0.5); }
        background { color = (0, 0.25, 1); }
        image { width = 64 * n; samples = 9; }";
    let look = load(source, &[Override::parse("n = 3").unwrap()]).unwrap().scene.look;
    assert_eq!(look.camera.eye, Some(glam::DVec3::new(3.0, -12.0, 1.0)));
    assert_eq!((look.camera.target, look.camera.up, look.camera.fov), (None, None, Some(33.0)));
    assert_eq!(look.lights[0].source, LightSource::Position((1.0, 2.0, 3.0).into()));
    assert_eq!((look.lights[0].shadow, look.lights[0].color), (false, glam::DVec3::ONE));
    assert_eq!(look.lights[1].source, LightSource::Direction((0.0, 0.0, -1.0).into()));
    assert_eq!((look.lights[1].shadow, look.lights[1].color), (true, glam::DVec3::new(2.0, 1.0, 0.5)));
    assert_eq!(look.background, Some(glam::DVec3::new(0.0, 0.25, 1.0)));
    assert_eq!((look.image.width, look.image.height, look.image.samples), (Some(192), None, Some(9)));
    assert_eq!((look.sky, look.image.integrator, look.image.bounces), (None, None, None));
}

#[test]
fn skies_are_read_as_far_as_they_are_described() {
    let source = "{ high = 1; } sphere
        sky { zenith = (0, 0.25, high); sun = (0, 0, 7); disc = high / 2; }
        image { integrator = path; bounces = 3; exposure = -high / 2; }";
    let look = load(source, &[]).unwrap().scene.look;
    let sky = look.sky.unwrap();
    assert_eq!(sky.zenith, Some(glam::DVec3::new(0.0, 0.25, 1.0)));
    assert_eq!((sky.horizon, sky.ground, sky.sunlight), (None, None, None));
    assert_eq!((sky.sun, sky.disc), (Some(glam::DVec3::Z), Some(0.5)));
    assert_eq!((look.image.integrator, look.image.bounces), (Some(Integrator::Path), Some(3)));
    assert_eq!(look.image.exposure, Some(-0.5));
}

#[test]
fn directions_may_have_any_length() {
    let source = "{} sphere light { direction = (1e300, 0, 0); } light { direction = (0, -1e-300, 0); }
        camera { up = (0, 0, 1e-320); }";
    let look = load(source, &[]).unwrap().scene.look;
    assert_eq!(look.lights[0].source, LightSource::Direction(glam::DVec3::X));
    assert_eq!(look.lights[1].source, LightSource::Direction(glam::DVec3::NEG_Y));
    assert_eq!(look.camera.up, Some(glam::DVec3::Z));
}

#[test]
fn places_survive_the_translation() {
    let source =
        "{ n = 2; } A\nA if(n, 2, 1)\n1: A -> sphere\n2: A -> {n = n - 1} move(0, 0, n) torus(0.2) & A";
    let scene = load(source, &[]).unwrap().scene;
    for (id, node) in scene.graph.nodes() {
        let text = &source[scene.sources.node(id).range()];
        let name = scene.graph.node_name(id);
        match node.kind() {
            "C" => assert_eq!(text, "{n = n - 1}"),
            "intersection" => assert!(text.starts_with("{n") && text.ends_with("& A")),
            _ => assert!(text.starts_with(&name), "{text} is not {name}"),
        }
        for (index, expr) in node.exprs().into_iter().enumerate() {
            let text = &source[scene.sources.expr(id, index).range()];
            assert!(expr.params().all(|param| text.contains(scene.graph.param_name(param))), "{text}");
            assert!(!text.contains([';', '=']), "{text} is more than an expression");
        }
    }
    let rules: Vec<_> =
        scene.sources.rules(scene.graph.root()).iter().map(|span| &source[span.range()]).collect();
    assert_eq!(rules[0], "1: A -> sphere");
    assert!(rules[1].starts_with("2: A -> {n"));
}

#[test]
fn bytes_that_are_no_text_are_pointed_at() {
    let report = decode("a.pcsg", b"{} sphere\n// caf\xe9\n").unwrap_err();
    assert_eq!(report.position(""), (2, 7));
    assert!(report.render("", "", false).contains("a.pcsg:2:7"));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, ..ProptestConfig::default() })]

    /// Whatever is typed, nothing panics, and nothing is told twice by the parser.
    #[test]
    fn damaged_files_are_survived(
        source in common::random_file(),
        damage in proptest::collection::vec((any::<u16>(), 0..30_usize), 1..6),
    ) {
        const PIECES: [&str; 30] = [
            "", "", "", "", "(", ")", "{", "}", ",", ";", "=", "->", "|", "-", "1:", "1", "n", "TREE", "twig", "camera {",
            "if(", "move(", "\n", "//", "\\", "é", "§", "\u{0}", "/*", "==",
        ];
        let mut text: Vec<char> = source.chars().collect();
        for (place, piece) in damage {
            let at = usize::from(place) % (text.len() + 1);
            if PIECES[piece].is_empty() {
                text.drain(at..(at + 3).min(text.len()));
            } else {
                text.splice(at..at, PIECES[piece].chars());
            }
        }
        let text: String = text.into_iter().collect();
        let parsed = parse(&text);
        let mut reports = parsed.diagnostics.clone();
        reports.dedup();
        prop_assert_eq!(reports.len(), parsed.diagnostics.len(), "{}", text);
        print(&parsed.tree);
        match load(&text, &[]) {
            Ok(lowered) => prop_assert!(!parsed.has_errors() && lowered.warnings.iter().all(|report| !report.is_error())),
            Err(reports) => {
                prop_assert!(reports.iter().any(Diagnostic::is_error), "no error is told in\n{}", text);
                for report in reports {
                    prop_assert!(!report.render("a.pcsg", &text, false).is_empty());
                }
            }
        }
    }
}
