//! The files a run leaves, and the report made from them. No solver and no transport is known here: solvers
//! hand over flat slices, the coupler rows and sums.
//!
//! | file in the run's folder | written with | content |
//! |---|---|---|
//! | `fluid.pvd`, `fluid/fluid_000000.vtu`, … and `structure` alike | [`Series`] | snapshots for ParaView, pyvista and meshio |
//! | `windows.csv` | [`Table`] | a row an accepted window |
//! | `probes.csv` | [`Table`] | `t`, then `<probe>.<component>` |
//! | `columns.json` | [`columns`] | unit and meaning of each column of these tables |
//! | `summary.json` | [`Summary`] | how the run ended, what it took, what was kept in balance |
//! | `checkpoints/*` | [`checkpoint`] | states of the run to go on from |
//!
//! [`write_report`] makes `report.html` and `frames/*.png` of them; [`report`] says which names it looks for,
//! and lends its plots and style to other pages.
//!
//! Start reading at [`vtu`] for snapshots, [`table`] and [`summary`] for numbers, [`report`] for the page.
//!
//! | notation | meaning |
//! |---|---|
//! | particle arrays | flat, `components` values a particle, particle after particle |
//! | `<owner>.<quantity>` | column of a table: `tip.ux`, `fluid.kinetic_energy` |
//! | units | SI throughout; in two dimensions masses, forces and energies are those of one metre of depth |
//!
//! A run can be killed at any moment: snapshots, collections and the summary are written aside and renamed
//! ([`atomic`]), tables grow by whole rows. A run that goes on has its tables cut to the checkpoint
//! ([`Table::go_on`]) and its snapshots numbered on ([`Series::go_on`]).

pub mod atomic;
pub mod checkpoint;
pub mod columns;
mod error;
pub mod files;
pub mod pvd;
pub mod report;
pub mod summary;
pub mod sums;
pub mod table;
pub mod vtu;
mod xml;

/// Makes a FIFO, for tests of what is refused.
#[cfg(test)]
fn mkfifo(path: &std::path::Path) -> bool {
    std::process::Command::new("mkfifo").arg(path).status().is_ok_and(|status| status.success())
}

pub use columns::Column;
pub use error::{Error, Result};
pub use pvd::Series;
pub use report::write_report;
pub use summary::Summary;
pub use table::Table;
pub use vtu::{ParticleFrame, PointArray, Values};
