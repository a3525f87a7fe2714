//! `meniscus bench`.

use super::{failed, say};
use crate::arguments::{Bench, Echo, Exchange};
use coupler::bench;
use interfaces::Address;
use std::process::ExitCode;

/// Measures, and prints the table line by line.
pub fn bench(arguments: &Bench) -> ExitCode {
    match arguments {
        Bench::Exchange(arguments) => exchange(arguments),
        Bench::Echo(arguments) => echo(arguments),
    }
}

fn exchange(arguments: &Exchange) -> ExitCode {
    let (executable, stop) = match (std::env::current_exe(), super::stop_flag()) {
        (Ok(executable), Ok(stop)) => (executable, stop),
        (Err(error), _) | (_, Err(error)) => return failed(error),
    };
    let options = bench::Options {
        points: arguments.points.clone(),
        windows: arguments.windows,
        share_core: !arguments.apart,
        executable,
        domain: arguments.domain.clone(),
        sections: super::SECTIONS.to_vec(),
        stop,
    };
    match bench::exchange(&options, |line| say(line)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => failed(error),
    }
}

fn echo(arguments: &Echo) -> ExitCode {
    let address = Address::parse(&arguments.run, arguments.role.into());
    match bench::echo(&address, arguments.taken, arguments.given) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => failed(error),
    }
}
