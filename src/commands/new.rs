//! `meniscus new`.

use super::{failed, say};
use crate::arguments::{New, Template};
use std::fs::{DirBuilder, OpenOptions};
use std::io::Write as _;
use std::process::ExitCode;

/// Writes a commented case that runs into a folder of its name.
pub fn new(arguments: &New) -> ExitCode {
    let text = match arguments.template {
        Template::DamBreak => include_str!("../templates/dam-break.toml"),
        Template::Tank => include_str!("../templates/tank.toml"),
        Template::Plate => include_str!("../templates/plate.toml"),
        Template::Coupled => include_str!("../templates/coupled.toml"),
    };
    let file = arguments.name.join("case.toml");
    let made = DirBuilder::new().recursive(true).create(&arguments.name);
    // A case that is there is somebody's work.
    let opened = made.and_then(|()| OpenOptions::new().write(true).create_new(true).open(&file));
    match opened.and_then(|mut opened| opened.write_all(text.as_bytes())) {
        Ok(()) => {
            let name = arguments.name.display();
            say(format_args!(
                "{}: a case to start from; next: meniscus check {name}, meniscus run {name}",
                file.display()
            ));
            ExitCode::SUCCESS
        }
        Err(error) => failed(format_args!("failed to write {}: {error}", file.display())),
    }
}
