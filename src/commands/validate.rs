//! `meniscus validate`.

use super::{FAILED, INTERRUPTED, WRONG, failed};
use crate::arguments::{Suite, Validate};
use std::process::ExitCode;
use validation::run::{Error, fails};
use validation::{page, study, tables};

/// Runs the suite, prints its tables and where to look. Fails if a judged measure misses its tolerance.
pub fn validate(arguments: &Validate) -> ExitCode {
    let suite = match arguments.suite {
        Suite::Structure => "structure",
        Suite::Fluid => "fluid",
        Suite::Fsi => "fsi",
    };
    let studies = match study::find(&arguments.cases, suite, arguments.case.as_deref()) {
        Ok(studies) => studies,
        Err(error) => {
            super::tell(format_args!("error: {error}"));
            return ExitCode::from(WRONG);
        }
    };
    let stop = match super::stop_flag() {
        Ok(stop) => stop,
        Err(error) => return failed(error),
    };
    let out = arguments.out.join("validate");
    let options = validation::Options {
        out: out.clone(),
        coarse: arguments.coarse,
        quiet: arguments.quiet,
        sections: super::SECTIONS.to_vec(),
        stop,
    };
    let tell = |line: &str| {
        if !arguments.quiet {
            super::tell(line);
        }
    };
    let results = match validation::run(studies, &options, &super::solver, &tell) {
        Ok(results) => results,
        Err(Error::Interrupted) => {
            eprintln!("interrupted; runs that are done are in {}", out.display());
            return ExitCode::from(INTERRUPTED);
        }
        Err(error @ Error::Case { .. }) => {
            super::tell(format_args!("error: {error}"));
            return ExitCode::from(WRONG);
        }
        Err(error) => return failed(error),
    };
    if results.is_empty() {
        eprintln!("error: no series of these cases has coarse resolutions; leave --coarse out");
        return ExitCode::from(WRONG);
    }
    println!("{}", tables::text(&results));
    let written = tables::write(&results, &out).and_then(|()| page::write(&results, suite, &out));
    match written {
        Ok(page) => {
            println!("tables      {}\npage        {}", out.join(tables::FILE).display(), page.display());
        }
        Err(error) => return failed(error),
    }
    if fails(&results) {
        eprintln!("error: a measure misses its tolerance");
        return ExitCode::from(FAILED);
    }
    ExitCode::SUCCESS
}
