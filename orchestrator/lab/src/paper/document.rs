//! The text and its tables.

use super::PaperArguments;
use super::claims::{self, Claim};
use super::numbers::{self, Number, shown};
use super::response::Quantity;
use super::runs::{Run, Series};
use super::statements::{EARTHQUAKES, FIGURES, FLEXIBLE};
use crate::fidelity;
use crate::study::StudyError;
use cofferdam_analysis::table::Table;
use cofferdam_scene::Side;
use cofferdam_unit::number::plain;
use std::fmt::Write;

/// All runs and their results.
pub struct All {
    /// Figure 3, and its closed form (over the hydrostatic pressure).
    pub rigid: Series,
    pub exact: Vec<f64>,
    /// Figure 4.
    pub flexible: Series,
    /// Figures 7 to 13, an earthquake each.
    pub cracked: [Series; 2],
    pub numbers: Vec<Number>,
    pub claims: Vec<Claim>,
}

impl All {
    /// Factor from pressure over hydrostatic to C_p = p/ρah of figure 3: g/a.
    pub fn coefficient(&self) -> f64 {
        let loaded = &self.rigid.base().loaded;
        loaded.scene.gravity / loaded.ground_motion.peak().0.abs()
    }

    /// Source of a figure's records.
    pub fn sources(&self, figure: u8) -> Vec<String> {
        let [koyna, newhall] = [0, 1].map(|index| {
            let earthquake = &EARTHQUAKES[index];
            self.cracked[index].source(earthquake.name, Some(earthquake.ground), earthquake.missing)
        });
        match figure {
            3 => Vec::new(),
            4 => vec![self.flexible.source(FLEXIBLE[1], None, "it may not be shipped")],
            8 | 10 => vec![koyna],
            9 | 11 => vec![newhall],
            _ => vec![koyna, newhall],
        }
    }
}

/// The base pressure of figure 3's dam over the hydrostatic one, at the instants of its runs.
///
/// **Errors**: the scene has no closed form.
pub fn closed_form(series: &Series) -> Result<Vec<f64>, StudyError> {
    let loaded = &series.base().loaded;
    let hydrostatic = loaded.scene.hydrostatic_base_pressure(Side::Upstream);
    let exact = fidelity::closed_form(&loaded.scene, &loaded.ground_motion)?;
    let missing = "figure 3 needs a vertical face, a level bed and no surface waves: there is no closed form";
    // At rest before the first step.
    let values = exact.ok_or_else(|| crate::study::unfit(missing))?;
    Ok(std::iter::once(0.0).chain(values).map(|pressure| pressure / hydrostatic).collect())
}

/// Largest difference of a run's base pressure from the closed form, over its peak.
pub fn error(run: &Run, exact: &[f64]) -> f64 {
    let found = run.response.column(Quantity::BasePressure);
    let apart = found.iter().zip(exact).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    apart / exact.iter().fold(f64::MIN_POSITIVE, |most, value| most.max(value.abs()))
}

/// The other choices of the cracked dam, the paper's numbers first.
pub fn open_choices(cracked: &[Series; 2]) -> Table {
    let mut table = Table::new([
        "earthquake",
        "run",
        "below, g",
        "above, g",
        "crest, g",
        "first large displacement, mm",
        "at, s",
        "residual sliding, mm",
        "rotation, mrad",
        "pressure over hydrostatic",
        "steps above the tolerance",
    ]);
    for (earthquake, series) in EARTHQUAKES.iter().zip(cracked) {
        let [below, above] = earthquake.accelerations.map(plain);
        let [swing, time] = earthquake.first_swing.map(plain);
        let none = || "–".to_owned();
        table.row([
            earthquake.name.to_owned(),
            "the paper".to_owned(),
            below,
            above,
            none(),
            swing,
            time,
            plain(earthquake.sliding[0]),
            plain(earthquake.rotation),
            none(),
            none(),
        ]);
        for Run { what, choice, response, .. } in &series.runs {
            let peak = |quantity| match response.column(quantity) {
                [] => none(),
                _ => shown(response.peak(quantity)),
            };
            let moves = !response.column(Quantity::Downstream).is_empty();
            let [swing, time] = response.first_swing();
            let of_dam = |value: f64| if moves { shown(value) } else { none() };
            table.row([
                earthquake.name.to_owned(),
                format!("{what}{}", if choice.is_some() { "*" } else { "" }),
                peak(Quantity::Below),
                peak(Quantity::Above),
                peak(Quantity::Crest),
                of_dam(swing),
                of_dam(time),
                of_dam(response.residual),
                peak(Quantity::Rotation),
                peak(Quantity::BasePressure),
                response.unconverged.to_string(),
            ]);
        }
    }
    table
}

/// Peak of the pressure coefficient, and the largest error, of each rise.
fn ramps(all: &All) -> Table {
    let mut table = Table::new(["run", "largest C_p", "off the closed form"]);
    for run in &all.rigid.runs {
        // Another rise has another closed form.
        let off = run.choice.is_none().then(|| error(run, &all.exact));
        table.row([
            run.what.clone(),
            shown(all.coefficient() * run.response.peak(Quantity::BasePressure)),
            off.map_or("–".to_owned(), |off| format!("{:.2} %", 100.0 * off)),
        ]);
    }
    table
}

/// Peak of the pressure at the base of figure 4's dam, and how far it is from that of the scene as it is.
fn flexible(series: &Series) -> Table {
    let mut table =
        Table::new(["run", "pressure over hydrostatic", "apart over time", "crest downstream, mm"]);
    let quantity = Quantity::BasePressure;
    for run in &series.runs {
        table.row([
            run.what.clone(),
            shown(run.response.peak(quantity)),
            format!("{:.0} %", 100.0 * run.response.apart(&series.base().response, quantity)),
            shown(run.response.peak(Quantity::Downstream)),
        ]);
    }
    table
}

/// The command line.
fn command(arguments: &PaperArguments) -> String {
    let PaperArguments { koyna_record, newhall_record, el_centro_record, coarse, .. } = arguments;
    let records = EARTHQUAKES
        .iter()
        .map(|earthquake| earthquake.option)
        .zip([koyna_record, newhall_record])
        .chain([(FLEXIBLE[2], el_centro_record)]);
    let given = records.filter_map(|(option, file)| {
        Some(format!(" {option} {}", file.as_ref()?.file_name()?.to_string_lossy()))
    });
    format!("cofferdam-lab paper{}{}", given.collect::<String>(), if *coarse { " --coarse" } else { "" })
}

/// The whole document.
pub fn text(arguments: &PaperArguments, all: &All) -> String {
    let runs =
        all.cracked.iter().chain([&all.flexible, &all.rigid]).map(|series| series.runs.len()).sum::<usize>();
    let mut text = format!("`{}`, {runs} runs\n\n", command(arguments));
    let mut sources = all.sources(7);
    sources.extend(all.sources(4));
    for source in sources {
        let _ = writeln!(text, "- {source}.");
    }
    let _ = write!(
        text,
        "\nNumbers of the paper's text. Least and most: over the scene as it is and the open choices (*) below.\n\n{}\n\
         Statements in words:\n\n{}\n\
         The cracked dam with other choices; * those that the paper leaves open:\n\n{}\n\
         Figure 3, p over ρah:\n\n{}\nFigure 4:\n\n{}\n",
        numbers::table(&all.numbers).markdown(),
        claims::table(&all.claims).markdown(),
        open_choices(&all.cracked).markdown(),
        ramps(all).markdown(),
        flexible(&all.flexible).markdown(),
    );
    for figure in &FIGURES {
        let _ = write!(
            text,
            "## Figure {}: {}\n\nThe paper: {}. Open: {}.\n\n![Figure {0}](figure-{0}.svg)\n\n",
            figure.number, figure.title, figure.says, figure.open
        );
    }
    text
}
