//! CSV tables that grow during a run: `windows.csv` (a row a window) and `probes.csv` (a row an output time).

use crate::columns::{self, Content};
use crate::error::{Error, Result, parse_error, read_error, write_error};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs::File;
use std::io::Write as _;
use std::path::{Path, PathBuf};

/// A table being written: one header, then rows of numbers.
///
/// Rows are gathered and handed to the operating system in one call, [`Table::ROWS_PER_FLUSH`] at a time, on
/// [`Table::flush`] and on drop, so that the file always ends with a whole row, also when this process is
/// killed. (Only a full disk can cut a row; [`read`] leaves such a last row out.)
#[derive(Debug)]
pub struct Table {
    path: PathBuf,
    file: File,
    columns: usize,
    buffer: String,
    buffered_rows: usize,
}

impl Table {
    /// Rows that a kill can cost at most.
    pub const ROWS_PER_FLUSH: usize = 16;

    /// Makes the file (an earlier one is emptied) and writes the header.
    ///
    /// # Errors
    /// [`Error::Write`] if the file cannot be made or written.
    pub fn create<S: AsRef<str>>(path: &Path, columns: &[S]) -> Result<Self> {
        let file = File::create(path).map_err(write_error(path))?;
        let header: Vec<String> = columns.iter().map(|column| quoted(column.as_ref())).collect();
        let mut table = Self {
            path: path.to_owned(),
            file,
            columns: columns.len(),
            buffer: header.join(",") + "\n",
            buffered_rows: 0,
        };
        table.flush()?;
        Ok(table)
    }

    /// Adds a row, one value a column. A value that does not exist is `f64::NAN`.
    ///
    /// # Errors
    /// [`Error::Row`] if there are more or fewer values than columns, [`Error::Write`] if the disk is full.
    pub fn row(&mut self, values: &[f64]) -> Result<()> {
        if values.len() != self.columns {
            return Err(Error::Row { path: self.path.clone(), found: values.len(), expected: self.columns });
        }
        for (index, &value) in values.iter().enumerate() {
            if index > 0 {
                self.buffer.push(',');
            }
            push_number(&mut self.buffer, value);
        }
        self.buffer.push('\n');
        self.buffered_rows += 1;
        if self.buffered_rows >= Self::ROWS_PER_FLUSH { self.flush() } else { Ok(()) }
    }

    /// Writes the rows gathered so far.
    ///
    /// # Errors
    /// [`Error::Write`] if the disk is full.
    pub fn flush(&mut self) -> Result<()> {
        let rows = std::mem::take(&mut self.buffer);
        self.buffered_rows = 0;
        self.file.write_all(rows.as_bytes()).map_err(write_error(&self.path))
    }
}

impl Drop for Table {
    fn drop(&mut self) {
        // A drop cannot report; who has to know calls `flush` before.
        let _ = self.flush();
    }
}

/// The shortest decimal text that reads back to the same bits; whole numbers without a point, so that counts
/// look like counts.
fn push_number(text: &mut String, value: f64) {
    let magnitude = value.abs();
    // Writing to a string cannot fail.
    let _ = if magnitude == 0.0 || (1e-4..1e15).contains(&magnitude) || !value.is_finite() {
        write!(text, "{value}")
    } else {
        write!(text, "{value:e}")
    };
}

fn quoted(name: &str) -> String {
    if name.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", name.replace('"', "\"\""))
    } else {
        name.to_owned()
    }
}

/// A table as it was read back.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Columns {
    /// Column names, in the file's order.
    pub names: Vec<String>,
    /// The columns, all of one length.
    pub columns: Vec<Vec<f64>>,
    /// What they are, as far as `columns.json` says.
    pub contents: BTreeMap<String, Content>,
}

impl Columns {
    /// The column of this name.
    pub fn get(&self, name: &str) -> Option<&[f64]> {
        let index = self.names.iter().position(|other| other == name)?;
        Some(&self.columns[index])
    }

    /// Unit of the column of this name as people write it; empty for a pure number, and where nobody says.
    pub fn unit(&self, name: &str) -> String {
        match self.contents.get(name).map_or("1", |content| content.unit.as_str()) {
            "1" => String::new(),
            unit => unit.replace('*', "·"),
        }
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.columns.first().map_or(0, Vec::len)
    }

    /// Name and values of each column.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &[f64])> {
        self.names.iter().map(String::as_str).zip(self.columns.iter().map(Vec::as_slice))
    }
}

/// Reads a table, and what its columns are from `columns.json` beside it. A last row that a kill cut short is
/// left out; an empty cell reads as not-a-number.
///
/// # Errors
/// [`Error::Read`] if it cannot be read, [`Error::Parse`] if a row before the last has another number of
/// cells than the header, or a cell is no number; as [`columns::read`].
pub fn read(path: &Path) -> Result<Columns> {
    let text = std::fs::read_to_string(path).map_err(read_error(path))?;
    let whole = &text[..text.rfind('\n').map_or(0, |end| end + 1)];
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(whole.as_bytes());
    let reason = |error: csv::Error| parse_error(path, error.to_string());
    let names: Vec<String> = reader.headers().map_err(reason)?.iter().map(str::to_owned).collect();
    let mut values = vec![Vec::new(); names.len()];
    for record in reader.records() {
        let record = record.map_err(reason)?;
        for (index, cell) in record.iter().enumerate() {
            let value = if cell.is_empty() { Ok(f64::NAN) } else { cell.parse() };
            let line = || record.position().map_or(0, csv::Position::line);
            values[index].push(value.map_err(|_| {
                parse_error(
                    path,
                    format!("`{cell}` in column `{}`, line {}, is no number", names[index], line()),
                )
            })?);
        }
    }
    let folder = path.parent().unwrap_or(Path::new(""));
    let file = path.file_name().unwrap_or_default().to_string_lossy();
    let contents = columns::read(folder)?.remove(file.as_ref()).unwrap_or_default();
    Ok(Columns { names, columns: values, contents })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_come_back_to_the_bit() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("windows.csv");
        let values = [0.1 + 0.2, 12.0, -1e-300, f64::MAX, f64::MIN_POSITIVE / 8.0, f64::NEG_INFINITY, -0.0];
        let names = ["a", "b,c", "d\"e", "f", "g", "h", "i"];
        Table::create(&path, &names).unwrap().row(&values).unwrap();
        let back = read(&path).unwrap();
        assert_eq!(back.names, names);
        for ((_, column), value) in back.iter().zip(values) {
            assert_eq!(column[0].to_bits(), value.to_bits());
        }
        assert!(std::fs::read_to_string(&path).unwrap().contains("0.30000000000000004,12,-1e-300,"));
    }

    #[test]
    fn rows_are_readable_while_the_writer_lives() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("probes.csv");
        let mut table = Table::create(&path, &["t", "tip.ux"]).unwrap();
        assert_eq!(read(&path).unwrap().rows(), 0);
        for row in 0..Table::ROWS_PER_FLUSH + 3 {
            table.row(&[row as f64, f64::NAN]).unwrap();
        }
        assert_eq!(read(&path).unwrap().rows(), Table::ROWS_PER_FLUSH);
        table.flush().unwrap();
        assert_eq!(read(&path).unwrap().rows(), Table::ROWS_PER_FLUSH + 3);
        table.row(&[99.0, 1.0]).unwrap();
        drop(table);
        assert_eq!(read(&path).unwrap().get("t").unwrap().last(), Some(&99.0));
    }

    #[test]
    fn a_cut_last_row_is_left_out_and_a_wrong_cell_is_named() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("t.csv");
        std::fs::write(&path, "t,x\n0,1\n1,2\n2,").unwrap();
        assert_eq!(read(&path).unwrap().rows(), 2);
        std::fs::write(&path, "t,x\n0,one\n").unwrap();
        let message = read(&path).unwrap_err().to_string();
        assert!(message.contains("`one`") && message.contains("line 2"), "{message}");
        let mut table = Table::create(&path, &["t"]).unwrap();
        assert!(matches!(table.row(&[1.0, 2.0]), Err(Error::Row { found: 2, expected: 1, .. })));
    }
}
