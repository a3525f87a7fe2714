//! The page: sections of figures and tables as one HTML file that needs nothing else.

use super::figures::{Comparison, Figure};
use super::frames::{FramePicture, Pictures};
use super::plot::chart;
use super::scale::{quantity, short};
use crate::columns::Contents;
use crate::summary::{Status, Summary};
use crate::table::Columns;
use crate::xml::escape;
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD as BASE64;
use std::fmt::Write as _;

/// What the page shows; an empty part is left out.
pub(crate) struct Page {
    pub title: String,
    pub summary: Option<Summary>,
    pub probes: Vec<Figure>,
    /// The table of probes, for its units.
    pub probe_columns: Columns,
    pub comparisons: Vec<Comparison>,
    pub frames: Pictures,
    pub coupling: Vec<Figure>,
    pub energy: Vec<Figure>,
    pub progress: Vec<Figure>,
    /// What the columns of the tables are.
    pub contents: Contents,
    /// What could not be read, in words.
    pub notes: Vec<String>,
}

const STYLE: &str = concat!(include_str!("../../assets/uplot/uPlot.min.css"), "\n", include_str!("page.css"));
const SCRIPT: &str = concat!(
    "/*\n",
    include_str!("../../assets/uplot/LICENSE"),
    "*/\n",
    include_str!("../../assets/uplot/uPlot.iife.min.js"),
    include_str!("report.js")
);

/// The whole document.
pub(crate) fn html(page: &Page) -> String {
    let mut text = String::new();
    if !page.notes.is_empty() {
        let items: String = page.notes.iter().map(|note| format!("<li>{}</li>", escape(note))).collect();
        let _ = writeln!(text, "<ul class=\"notes\">{items}</ul>");
    }
    if let Some(summary) = &page.summary {
        head(&mut text, summary);
        run_table(&mut text, summary, &page.probe_columns);
        role_table(&mut text, summary);
    }
    figures(&mut text, "Probes", &page.probes, &comparison_table(&page.comparisons));
    frames(&mut text, &page.frames);
    figures(&mut text, "Coupling", &page.coupling, "");
    figures(&mut text, "Energy", &page.energy, "");
    figures(&mut text, "Course of the run", &page.progress, "");
    column_table(&mut text, &page.contents);
    document(&page.title, &text)
}

/// A whole document of one style with the reports: its title, and the HTML below the heading that it makes of
/// it.
pub fn document(title: &str, body: &str) -> String {
    let title = escape(title);
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta name=\"color-scheme\" content=\"light dark\">\n<title>{title}</title>\n<style>\n{STYLE}</style>\n\
         </head>\n<body>\n<main>\n<h1>{title}</h1>\n\
         <noscript><p class=\"message\">The curves are drawn by a script in this file, which is not allowed to run here.</p></noscript>\n\
         {body}</main>\n<script>\n{SCRIPT}</script>\n</body>\n</html>\n"
    )
}

fn head(text: &mut String, summary: &Summary) {
    let word = summary.status.word();
    let _ = writeln!(
        text,
        "<p><span class=\"status {word}\">{word}</span> {} s simulated in {} s, {} windows, {} sub-steps.</p>",
        short(summary.simulated_seconds),
        short(summary.wall_seconds),
        summary.windows,
        summary.sub_steps
    );
    if let Some(message) = &summary.message {
        let class = if summary.status == Status::Completed { "" } else { " class=\"message\"" };
        let _ = writeln!(text, "<p{class}>{}</p>", escape(message));
    }
}

fn run_table(text: &mut String, summary: &Summary, probes: &Columns) {
    let mut rows: Vec<(&str, String)> = Vec::new();
    rows.extend(summary.seams.iter().map(|seam| ("Seam", seam.words())));
    if let Some(condition) = &summary.condition_46 {
        let pair = |r: &crate::summary::Residual| format!("largest {}, rms {}", short(r.max), short(r.rms));
        rows.push(("Residual of (46) before", pair(&condition.before)));
        rows.push(("Residual of (46) after", pair(&condition.after)));
    }
    let balances = &summary.balances;
    let vector = |v: &[f64]| {
        let parts: Vec<String> = v.iter().map(|&c| short(c)).collect();
        format!("({}) N·s", parts.join(", "))
    };
    if !balances.impulse_given_newton_seconds.is_empty() {
        rows.push(("Impulse given by the fluid", vector(&balances.impulse_given_newton_seconds)));
    }
    if !balances.impulse_taken_newton_seconds.is_empty() {
        rows.push(("Impulse taken by the structure", vector(&balances.impulse_taken_newton_seconds)));
    }
    if let Some(work) = balances.work_given_joules {
        rows.push(("Work given by the fluid", quantity(work, "J")));
    }
    if let Some(work) = balances.work_taken_joules {
        rows.push(("Work taken by the structure", quantity(work, "J")));
    }
    if let Some(energy) = &balances.energy {
        let both = format!("{} → {}", quantity(energy.start_joules, "J"), quantity(energy.end_joules, "J"));
        rows.push(("Energy, start → end", both));
        rows.push(("Largest rise of energy", quantity(energy.largest_rise_joules, "J")));
        rows.push(("Energy that the motion has", quantity(energy.moved_joules, "J")));
    }
    if let Some(fluid) = &summary.fluid {
        rows.push(("Drift of the fluid's volume", format!("{} of it", short(fluid.volume_drift))));
        rows.push((
            "Fluid particles lost / left",
            format!("{} / {}", fluid.particles_lost, fluid.particles_left),
        ));
    }
    for (probe, extremes) in &summary.probes {
        let unit = probes.unit(probe);
        let at = |value: f64, time: f64| format!("{} at {} s", quantity(value, &unit), short(time));
        let (max, min) = (at(extremes.max, extremes.max_time), at(extremes.min, extremes.min_time));
        rows.push((probe, format!("largest {max}, least {min}")));
    }
    rows.push(("Threads a solver", summary.threads.to_string()));
    rows.push(("Version", summary.version.clone()));
    rows.push(("Case hash", summary.case_hash.clone()));
    rows.retain(|(_, value)| !value.is_empty());
    text.push_str("<div class=\"scroll\"><table class=\"pairs\">\n");
    for (name, value) in rows {
        let _ = writeln!(text, "<tr><th scope=\"row\">{}</th><td>{}</td></tr>", escape(name), escape(&value));
    }
    text.push_str("</table></div>\n");
}

fn role_table(text: &mut String, summary: &Summary) {
    if summary.roles.is_empty() {
        return;
    }
    text.push_str(
        "<div class=\"scroll\"><table>\n<tr><th>role</th><th>computing (s)</th>\
         <th>waiting (s)</th><th>share</th><th>memory (MB)</th></tr>\n",
    );
    let known = |count: u64, value: String| if count == 0 { "–".to_owned() } else { value };
    for (name, role) in &summary.roles {
        let _ = writeln!(
            text,
            "<tr><th scope=\"row\">{}</th><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>",
            escape(name),
            short(role.compute_seconds),
            short(role.wait_seconds),
            short(role.share),
            known(role.peak_memory_bytes, format!("{:.0}", role.peak_memory_bytes as f64 / 1e6)),
        );
    }
    text.push_str("</table></div>\n");
}

fn comparison_table(comparisons: &[Comparison]) -> String {
    if comparisons.is_empty() {
        return String::new();
    }
    let mut text = String::from(
        "<div class=\"scroll\"><table>\n<tr><th>probe</th><th>reference</th><th>points</th><th>rms difference</th>\
         <th>largest difference</th><th>peak, reference</th><th>peak, run</th></tr>\n",
    );
    for c in comparisons {
        let cells: String = [c.root_mean_square, c.largest, c.reference_peak, c.run_peak]
            .into_iter()
            .map(|value| format!("<td>{}</td>", escape(&quantity(value, &c.unit))))
            .collect();
        let _ = writeln!(
            text,
            "<tr><th scope=\"row\">{}</th><td>{}</td><td>{}</td>{cells}</tr>",
            escape(&c.probe),
            escape(&c.label),
            c.points
        );
    }
    text.push_str("</table></div>\n");
    text
}

fn figures(text: &mut String, title: &str, figures: &[Figure], after: &str) {
    let drawn: Vec<(String, &str)> =
        figures.iter().filter_map(|figure| Some((chart(&figure.plot)?, figure.caption.as_str()))).collect();
    if drawn.is_empty() {
        return;
    }
    let _ = writeln!(text, "<h2>{title}</h2>\n<div class=\"figures\">");
    for (chart, caption) in drawn {
        let _ = write!(text, "<figure>\n{chart}");
        if !caption.is_empty() {
            let _ = writeln!(text, "<figcaption>{}</figcaption>", escape(caption));
        }
        text.push_str("</figure>\n");
    }
    let _ = writeln!(text, "</div>\n{after}");
}

/// Pictures over time as a player, and those beside it; without its script the player shows them all.
fn frames(text: &mut String, Pictures { moments, others }: &Pictures) {
    let figures = |text: &mut String, pictures: &[FramePicture]| {
        text.push_str("<div class=\"figures\">\n");
        for FramePicture { caption, file, png } in pictures {
            let caption = escape(caption);
            let _ = writeln!(
                text,
                "<figure>\n<img alt=\"particles: {caption}\" src=\"data:image/png;base64,{}\">\n\
                 <figcaption>{caption} (frames/{})</figcaption>\n</figure>",
                BASE64.encode(png),
                escape(&file.file_name().unwrap_or_default().to_string_lossy())
            );
        }
        text.push_str("</div>\n");
    };
    if moments.is_empty() {
        return;
    }
    let _ = writeln!(
        text,
        "<h2>Pressure in the fluid and stress in the structure</h2>\n<div class=\"player\">\n<div class=\"controls\">\
         <button type=\"button\">Play</button>\
         <input type=\"range\" aria-label=\"frame\" min=\"0\" max=\"{}\" value=\"0\"></div>",
        moments.len() - 1
    );
    figures(text, moments);
    text.push_str("</div>\n");
    if !others.is_empty() {
        figures(text, others);
    }
}

/// Unit and meaning of each column, folded away.
fn column_table(text: &mut String, contents: &Contents) {
    for (table, columns) in contents {
        let _ = writeln!(
            text,
            "<details><summary>Columns of {}</summary>\n<div class=\"scroll\"><table>\n\
             <tr><th>column</th><th>unit</th><th>meaning</th></tr>",
            escape(table)
        );
        for (name, content) in columns {
            let [name, unit, meaning] = [name, &content.unit, &content.meaning].map(|cell| escape(cell));
            let _ = writeln!(text, "<tr><th scope=\"row\">{name}</th><td>{unit}</td><td>{meaning}</td></tr>");
        }
        text.push_str("</table></div>\n</details>\n");
    }
}
