//! Prints the JSON schema of the case file:
//! `cargo run -p interfaces --example case-schema > docs/case.schema.json`.

fn main() {
    println!("{:#}", interfaces::case::schema());
}
