//! The transport: within one process, between real processes, and with a participant in another language.

mod hostile;
mod in_process;
mod processes;
mod python;
mod support;
