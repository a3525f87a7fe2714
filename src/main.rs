//! The `meniscus` command: arguments → one call.

mod arguments;
mod commands;

use clap::Parser;
use std::process::ExitCode;

fn main() -> ExitCode {
    use arguments::Command;
    let command = arguments::Arguments::parse().command;
    if command.is_of_the_user() {
        commands::tidy();
    }
    match command {
        Command::Run(run) => commands::run::run(&run),
        Command::New(new) => commands::new::new(&new),
        Command::Check(check) => commands::check::check(&check),
        Command::Status(status) => commands::status::status(&status),
        Command::Ask(ask) => commands::status::ask(&ask),
        Command::Report(report) => commands::report::report(&report),
        Command::Validate(validate) => commands::validate::validate(&validate),
        Command::Sweep(sweep) => commands::sweep::sweep(&sweep),
        Command::Fluid(solver) => commands::participant::solver(&solver, interfaces::Role::Fluid),
        Command::Structure(solver) => commands::participant::solver(&solver, interfaces::Role::Structure),
        Command::Fmu(fmu) => commands::participant::fmu(&fmu),
        Command::Mock(mock) => commands::participant::mock(&mock),
        Command::ExportFmu(export) => commands::export_fmu::export_fmu(&export),
        Command::ProbeFmu { role, case } => commands::participant::probe(&case, role.into()),
        Command::Guard { run } => {
            let _ = commands::checkpoint_flag();
            coupler::launch::guard::stand(std::io::stdin().lock(), &run);
            ExitCode::SUCCESS
        }
        Command::Become { words } => commands::participant::become_other(&words),
        Command::Bench(bench) => commands::bench::bench(&bench),
        Command::Schema(schema) => commands::schema::schema(&schema),
    }
}
