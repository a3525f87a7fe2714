//! The files of a run as others meet them: after a kill, and as a report.

mod killed;
mod report;
