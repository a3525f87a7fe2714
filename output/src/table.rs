//! CSV tables that grow during a run: `windows.csv` and `probes.csv` (a row a window).

use crate::columns::{self, Content};
use crate::error::{Error, Result, parse_error, read_error, write_error};
use crate::files;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs::File;
use std::io::{BufRead as _, BufReader, Read as _, Seek as _, SeekFrom, Write as _};
use std::path::{Path, PathBuf};

/// Longest row that is read (bytes).
const LONGEST_ROW: u64 = 1 << 20;

/// A table being written: one header, then rows of numbers.
///
/// Rows are gathered and handed to the operating system in one call, [`Table::ROWS_PER_FLUSH`] at a time, on
/// [`Table::flush`] and on drop, so that the file always ends with a whole row, also when this process is
/// killed or the disk is full: rows that were written in part are taken back, and no more are taken.
#[derive(Debug)]
pub struct Table {
    path: PathBuf,
    file: File,
    columns: usize,
    buffer: String,
    buffered_rows: usize,
    /// Bytes of the rows that are whole in the file.
    written: u64,
    /// Whether rows could not be written.
    failed: bool,
}

impl Table {
    /// Rows that a kill can cost at most.
    pub const ROWS_PER_FLUSH: usize = 16;

    /// Makes the file (an earlier one is emptied) and writes the header.
    ///
    /// # Errors
    /// [`Error::Write`] if the file cannot be made or written.
    pub fn create<S: AsRef<str>>(path: &Path, columns: &[S]) -> Result<Self> {
        let file = files::create(path).map_err(write_error(path))?;
        let mut table = Self {
            path: path.to_owned(),
            file,
            columns: columns.len(),
            buffer: header(columns),
            buffered_rows: 0,
            written: 0,
            failed: false,
        };
        table.flush()?;
        Ok(table)
    }

    /// Opens the table that an earlier run left, with this header. It takes rows after
    /// [`go_on`](Self::go_on).
    ///
    /// # Errors
    /// [`Error::Read`] if it cannot be opened, [`Error::Parse`] if it has another header.
    pub fn reopen<S: AsRef<str>>(path: &Path, columns: &[S]) -> Result<Self> {
        let file = files::reopen(path).map_err(read_error(path))?;
        let expected = header(columns);
        let mut found = vec![0; expected.len()];
        let is_same = (&file).read_exact(&mut found).is_ok() && found == expected.as_bytes();
        if !is_same {
            return Err(parse_error(path, "its columns are not those that this case has"));
        }
        Ok(Self {
            path: path.to_owned(),
            file,
            columns: columns.len(),
            buffer: String::new(),
            buffered_rows: 0,
            written: expected.len() as u64,
            failed: false,
        })
    }

    /// Cuts the table to its first `bytes` bytes, which end with a row; the next one stands behind them.
    ///
    /// # Errors
    /// [`Error::Parse`] if no row ends there; [`Error::Read`], [`Error::Write`].
    pub fn go_on(&mut self, bytes: u64) -> Result<()> {
        let mut last = [0];
        let at = self.file.seek(SeekFrom::Start(bytes.saturating_sub(1)));
        let read = at.and_then(|_| self.file.read(&mut last)).map_err(read_error(&self.path))?;
        if read != 1 || last != *b"\n" || bytes < self.written {
            return Err(parse_error(&self.path, format!("no row ends at byte {bytes}")));
        }
        self.written = bytes;
        self.file.set_len(bytes).map_err(write_error(&self.path))
    }

    /// Forces all rows so far to the disk. Gives the bytes that the table has then.
    ///
    /// # Errors
    /// [`Error::Write`].
    pub fn sync(&mut self) -> Result<u64> {
        self.flush()?;
        self.file.sync_data().map_err(write_error(&self.path))?;
        Ok(self.written)
    }

    /// Adds a row, one value a column. A value that does not exist is `f64::NAN`, and has an empty cell.
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
    /// [`Error::Write`] if the disk is full. Later calls do nothing then.
    pub fn flush(&mut self) -> Result<()> {
        let rows = std::mem::take(&mut self.buffer);
        self.buffered_rows = 0;
        if self.failed {
            return Ok(());
        }
        self.file.write_all(rows.as_bytes()).map_err(|error| {
            self.failed = true;
            // What is left of a cut row is left out when it is read, too.
            let _ = self.file.set_len(self.written);
            write_error(&self.path)(error)
        })?;
        self.written += rows.len() as u64;
        Ok(())
    }

    /// Ends the table where `keep`, which is told of each row its number and its first cell, first says no;
    /// rows that are not written yet are given up.
    ///
    /// # Errors
    /// [`Error::Write`], [`Error::Read`].
    pub fn cut(&mut self, keep: impl Fn(u64, f64) -> bool) -> Result<()> {
        (self.failed, self.buffered_rows) = (true, 0);
        self.buffer.clear();
        let file = files::open(&self.path, u64::MAX).map_err(read_error(&self.path))?;
        let mut lines = BufReader::new(file);
        let (mut kept, mut line, mut row) = (0, String::new(), None);
        loop {
            line.clear();
            let length = lines.read_line(&mut line).map_err(read_error(&self.path))?;
            let first = || line.split(',').next()?.trim().parse().ok();
            let is_kept = row.is_none_or(|row| first().is_some_and(|first| keep(row, first)));
            if !line.ends_with('\n') || !is_kept {
                break;
            }
            kept += length as u64;
            row = Some(row.map_or(0, |row| row + 1));
        }
        self.written = kept;
        self.file.set_len(kept).map_err(write_error(&self.path))
    }

    /// First cell of the last row in the file.
    ///
    /// # Errors
    /// [`Error::Read`].
    pub fn last_first_cell(&self) -> Result<Option<f64>> {
        let file = files::open(&self.path, u64::MAX).map_err(read_error(&self.path))?;
        let last = BufReader::new(file.take(self.written)).lines().skip(1).last();
        let last = last.transpose().map_err(read_error(&self.path))?;
        Ok(last.and_then(|line| line.split(',').next()?.parse().ok()))
    }

    /// Rows that are whole in the file.
    ///
    /// # Errors
    /// [`Error::Read`].
    pub fn whole_rows(&self) -> Result<u64> {
        let file = files::open(&self.path, u64::MAX).map_err(read_error(&self.path))?;
        let lines = BufReader::new(file.take(self.written)).split(b'\n').count();
        Ok(lines.saturating_sub(1) as u64)
    }
}

impl Drop for Table {
    fn drop(&mut self) {
        // A drop cannot report; who has to know calls `flush` before.
        let _ = self.flush();
    }
}

/// The shortest decimal text that reads back to the same bits, none for not-a-number; whole numbers without a
/// point, so that counts look like counts.
pub fn push_number(text: &mut String, value: f64) {
    let magnitude = value.abs();
    // What does not exist has an empty cell.
    if value.is_nan() {
        return;
    }
    // Writing to a string cannot fail.
    let _ = if magnitude == 0.0 || (1e-4..1e15).contains(&magnitude) || !value.is_finite() {
        write!(text, "{value}")
    } else {
        write!(text, "{value:e}")
    };
}

fn header<S: AsRef<str>>(columns: &[S]) -> String {
    let names: Vec<String> = columns.iter().map(|column| quoted(column.as_ref())).collect();
    names.join(",") + "\n"
}

/// A word as a cell: what has a comma, a quote or a line's end in it stands in quotes.
pub fn quoted(name: &str) -> String {
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
    read_at_most(path, usize::MAX)
}

/// [`read`], for curves: of a table of more than `rows` rows, always two of several rows in a sequence are
/// kept, with the smallest and the largest value of each column in the order in which they came.
///
/// # Errors
/// As [`read`].
pub fn read_at_most(path: &Path, rows: usize) -> Result<Columns> {
    let mut file = files::open(path, u64::MAX).map_err(read_error(path))?;
    let whole = whole_length(&mut file).map_err(read_error(path))?;
    let mut lines = BufReader::new(file.take(whole));
    let mut line = String::new();
    let mut next = |line: &mut String| -> Result<bool> {
        line.clear();
        let length = lines.by_ref().take(LONGEST_ROW).read_line(line).map_err(read_error(path))?;
        if length as u64 == LONGEST_ROW {
            return Err(parse_error(path, format!("a row has more than {LONGEST_ROW} bytes")));
        }
        Ok(length > 0)
    };
    next(&mut line)?;
    let mut header = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(line.as_bytes());
    let names = header.headers().map_err(|error| parse_error(path, error.to_string()))?;
    let names: Vec<String> = names.iter().map(str::to_owned).collect();
    let mut values = vec![Vec::new(); names.len()];
    let (mut thinned, mut number) = (Thinned::new(rows), 1);
    while next(&mut line)? {
        number += 1;
        let mut cells = line.trim_end_matches(['\r', '\n']).split(',').map(str::trim);
        let found = cells.clone().count();
        if found != names.len() {
            let what = format!("line {number} has {found} cells, and there are {} columns", names.len());
            return Err(parse_error(path, what));
        }
        for ((cell, column), name) in cells.by_ref().zip(&mut values).zip(&names) {
            let value = if cell.is_empty() { Ok(f64::NAN) } else { cell.parse() };
            column.push(value.map_err(|_| {
                let cell: String = cell.chars().take(40).collect();
                parse_error(path, format!("`{cell}` in column `{name}`, line {number}, is no number"))
            })?);
        }
        thinned.row(&mut values);
    }
    let folder = path.parent().unwrap_or(Path::new(""));
    let file = path.file_name().unwrap_or_default().to_string_lossy();
    let contents = columns::read(folder)?.remove(file.as_ref()).unwrap_or_default();
    Ok(Columns { names, columns: values, contents })
}

/// Columns that are halved whenever they are full.
struct Thinned {
    most: usize,
    /// Rows at the end that no halving has seen yet are gathered until they are as many as one row of those
    /// before stands for.
    each: usize,
    settled: usize,
}

impl Thinned {
    fn new(most: usize) -> Self {
        Self { most: most.max(8), each: 1, settled: 0 }
    }

    /// After a row was added to each column.
    fn row(&mut self, columns: &mut [Vec<f64>]) {
        let length = columns.first().map_or(0, Vec::len);
        if length - self.settled == 2 * self.each {
            if self.each > 1 {
                columns.iter_mut().for_each(|column| reduce(column, self.settled, 2 * self.each));
            }
            self.settled = columns.first().map_or(0, Vec::len);
            if self.settled >= self.most {
                columns.iter_mut().for_each(|column| reduce(column, 0, 4));
                self.settled = columns.first().map_or(0, Vec::len);
                self.each *= 2;
            }
        }
    }
}

/// From `start` on, leaves of each `size` values the smallest and the largest, in the order in which they
/// came.
fn reduce(column: &mut Vec<f64>, start: usize, size: usize) {
    let mut kept = start;
    for first in (start..column.len()).step_by(size) {
        let values = &column[first..column.len().min(first + size)];
        let place = |of: fn(&f64, &f64) -> std::cmp::Ordering| {
            let numbers = values.iter().enumerate().filter(|(_, value)| !value.is_nan());
            numbers.min_by(|a, b| of(a.1, b.1)).map(|(index, _)| index)
        };
        let least = place(f64::total_cmp);
        let most = place(|a, b| b.total_cmp(a));
        let pair = match (least, most) {
            (Some(least), Some(most)) => [values[least.min(most)], values[least.max(most)]],
            _ => [f64::NAN; 2],
        };
        column[kept..kept + 2].copy_from_slice(&pair);
        kept += 2;
    }
    column.truncate(kept);
}

/// Bytes up to the end of the last whole row.
fn whole_length(file: &mut File) -> std::io::Result<u64> {
    let length = file.metadata()?.len();
    let start = length.saturating_sub(LONGEST_ROW);
    file.seek(SeekFrom::Start(start))?;
    let mut tail = Vec::new();
    std::io::Read::by_ref(file).take(length - start).read_to_end(&mut tail)?;
    file.rewind()?;
    Ok(tail.iter().rposition(|byte| *byte == b'\n').map_or(0, |end| start + end as u64 + 1))
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
    fn a_long_table_is_thinned_and_keeps_its_extremes() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("windows.csv");
        let mut table = Table::create(&path, &["t", "x", "none"]).unwrap();
        for row in 0..10_000 {
            let peak = if row == 7_001 { 9.0 } else { 0.0 };
            table.row(&[f64::from(row), peak + (0.01 * f64::from(row)).sin(), f64::NAN]).unwrap();
        }
        drop(table);
        let (whole, thinned) = (read(&path).unwrap(), read_at_most(&path, 100).unwrap());
        assert_eq!(whole.rows(), 10_000);
        assert!((50..300).contains(&thinned.rows()), "{}", thinned.rows());
        assert!(thinned.columns.iter().all(|column| column.len() == thinned.rows()));
        let t = thinned.get("t").unwrap();
        assert!(t.is_sorted() && t[0] == 0.0 && t.last() == Some(&9999.0));
        let largest = |columns: &Columns| columns.get("x").unwrap().iter().copied().fold(0.0, f64::max);
        assert_eq!(largest(&thinned), largest(&whole));
        assert!(thinned.get("none").unwrap().iter().all(|value| value.is_nan()));
    }

    #[test]
    fn words_with_commas_and_quotes_are_one_cell() {
        let cells = ["a", "b,c", "say \"x\"", "d\ne"].map(quoted);
        assert_eq!(cells, ["a", "\"b,c\"", "\"say \"\"x\"\"\"", "\"d\ne\""]);
    }

    #[test]
    fn a_table_goes_on_behind_a_row() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("windows.csv");
        let mut table = Table::create(&path, &["window", "x"]).unwrap();
        table.row(&[0.0, 0.5]).unwrap();
        let bytes = table.sync().unwrap();
        table.row(&[1.0, 0.25]).unwrap();
        drop(table);
        assert!(Table::reopen(&path, &["window", "y"]).unwrap_err().to_string().contains("columns"));
        let mut again = Table::reopen(&path, &["window", "x"]).unwrap();
        for wrong in [0, 3, bytes - 1, bytes + 1, 1000] {
            assert!(again.go_on(wrong).unwrap_err().to_string().contains("no row ends"), "{wrong}");
        }
        again.go_on(bytes).unwrap();
        again.row(&[1.0, 2.0]).unwrap();
        drop(again);
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "window,x\n0,0.5\n1,2\n");
    }

    #[test]
    fn a_table_is_cut_at_a_row() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("windows.csv");
        let mut table = Table::create(&path, &["window", "x"]).unwrap();
        for row in 0..40 {
            table.row(&[f64::from(row / 2), 1.0]).unwrap();
        }
        assert_eq!(table.whole_rows().unwrap(), 32);
        table.cut(|_, window| window < 9.0).unwrap();
        assert_eq!(table.whole_rows().unwrap(), 18);
        table.cut(|row, _| row < 5).unwrap();
        table.row(&[0.0, 0.0]).unwrap();
        drop(table);
        assert_eq!(read(&path).unwrap().rows(), 5);
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
