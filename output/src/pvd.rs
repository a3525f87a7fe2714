//! A series of particle snapshots in time: `NAME/NAME_000000.vtu`, … and the collection `NAME.pvd` over them.

use crate::atomic;
use crate::error::{Result, parse_error, read_error, write_error};
use crate::files;
use crate::vtu::{self, ParticleFrame};
use crate::xml;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Writer of one medium's snapshots. After each [`Series::write`] the collection names exactly the snapshots
/// that are whole on the disk, so the series can be opened while the run goes on, and after it was killed.
#[derive(Debug)]
pub struct Series {
    dir: PathBuf,
    name: String,
    /// Those that the collection names.
    entries: Vec<SeriesEntry>,
    /// Times (s) of all that were written, whose number is that of the next.
    times: Vec<f64>,
}

/// One snapshot of a series.
#[derive(Debug, Clone, PartialEq)]
pub struct SeriesEntry {
    /// Simulated time in s.
    pub time: f64,
    /// The VTU file, relative to the folder of the `.pvd` when writing, joined to it when read.
    pub file: PathBuf,
}

impl Series {
    /// Starts the series `name` in `dir` (made if need be): writes an empty `dir/name.pvd`, the place of the
    /// snapshots is `dir/name/`. Snapshots of an earlier run there are overwritten as this one reaches them,
    /// and are out of the collection at once.
    ///
    /// # Errors
    /// [`crate::Error::Write`] if the folder cannot be made or the collection not be written.
    pub fn create(dir: &Path, name: &str) -> Result<Self> {
        let folder = dir.join(name);
        files::folder(&folder).map_err(write_error(&folder))?;
        let series =
            Self { dir: dir.to_owned(), name: name.to_owned(), entries: Vec::new(), times: Vec::new() };
        series.write_collection()?;
        Ok(series)
    }

    /// Writes the next snapshot and then the collection, and returns the snapshot's path.
    ///
    /// # Errors
    /// As [`vtu::write`].
    pub fn write(&mut self, frame: &ParticleFrame) -> Result<PathBuf> {
        let file = self.file(self.times.len());
        let path = self.dir.join(&file);
        vtu::write(&path, frame)?;
        self.times.push(frame.time);
        self.entries.push(SeriesEntry { time: frame.time, file });
        self.write_collection()?;
        Ok(path)
    }

    /// Times (s) of the snapshots so far.
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// Goes on behind snapshots of these times (s), which an earlier run left in the folder. The collection
    /// names those of them that are there.
    ///
    /// # Errors
    /// [`crate::Error::Write`] if the collection cannot be written.
    pub fn go_on(&mut self, times: Vec<f64>) -> Result<()> {
        let all =
            times.iter().enumerate().map(|(number, &time)| SeriesEntry { time, file: self.file(number) });
        self.entries = all.filter(|entry| self.dir.join(&entry.file).exists()).collect();
        self.times = times;
        self.write_collection()
    }

    /// Number of snapshots so far.
    pub fn len(&self) -> usize {
        self.times.len()
    }

    /// Whether there is no snapshot yet.
    pub fn is_empty(&self) -> bool {
        self.times.is_empty()
    }

    fn file(&self, number: usize) -> PathBuf {
        Path::new(&self.name).join(format!("{}_{number:06}.vtu", self.name))
    }

    fn write_collection(&self) -> Result<()> {
        let mut text = String::from(
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"LittleEndian\">\n\
             <Collection>\n",
        );
        for entry in &self.entries {
            let file = xml::escape(&entry.file.to_string_lossy().replace('\\', "/"));
            let _ = writeln!(text, "<DataSet timestep=\"{}\" part=\"0\" file=\"{file}\"/>", entry.time);
        }
        text.push_str("</Collection>\n</VTKFile>\n");
        atomic::write_file(&self.dir.join(format!("{}.pvd", self.name)), text.as_bytes())
    }
}

/// The snapshots that a `.pvd` written by [`Series`] names, in its order, with paths joined to its folder.
///
/// # Errors
/// [`crate::Error::Read`] if it cannot be read, [`crate::Error::Parse`] if an entry is not of that layout, or
/// names a file outside of the folder.
pub fn read(path: &Path) -> Result<Vec<SeriesEntry>> {
    let text = files::read_text(path, files::WORDS).map_err(read_error(path))?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let whole = folder.canonicalize().map_err(read_error(folder))?;
    let entry = |line: &str| -> Option<SeriesEntry> {
        let value = |name: &str| Some(line.split_once(&format!(" {name}=\""))?.1.split_once('"')?.0);
        Some(SeriesEntry {
            time: value("timestep")?.parse().ok()?,
            file: folder.join(xml::unescape(value("file")?)),
        })
    };
    let mut entries = Vec::new();
    for line in text.lines().filter(|line| line.starts_with("<DataSet ")) {
        let found = entry(line).ok_or_else(|| parse_error(path, format!("no time and file in `{line}`")))?;
        // One that is not there is told when it is read.
        if found.file.canonicalize().is_ok_and(|file| !file.starts_with(&whole)) {
            return Err(parse_error(path, format!("`{line}` names a file outside of this folder")));
        }
        entries.push(found);
    }
    Ok(entries)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn a_collection_that_names_files_elsewhere_is_refused() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("fluid.pvd");
        std::os::unix::fs::symlink("/etc", dir.path().join("fluid")).unwrap();
        for file in ["/dev/zero", "../../../../../../../../etc/hostname", "fluid/hostname"] {
            fs::write(&path, format!("<DataSet timestep=\"0\" part=\"0\" file=\"{file}\"/>\n")).unwrap();
            let error = read(&path).unwrap_err().to_string();
            assert!(error.contains("outside") && error.contains(file), "{error}");
        }
    }

    #[test]
    fn the_collection_is_whole_after_every_snapshot() {
        let dir = tempfile::tempdir().unwrap();
        let mut series = Series::create(dir.path(), "fluid").unwrap();
        let collection = dir.path().join("fluid.pvd");
        assert!(series.is_empty() && read(&collection).unwrap().is_empty());
        for step in 0..3 {
            let time = 0.1 * f64::from(step);
            let frame = ParticleFrame { time, dimension: 2, positions: &[time, 0.0], arrays: &[] };
            series.write(&frame).unwrap();
            let entries = read(&collection).unwrap();
            assert_eq!(entries.len(), series.len());
            // The time is the same to the bit by both ways.
            assert_eq!(entries[step as usize].time, time);
            assert_eq!(vtu::read(&entries[step as usize].file).unwrap().time, time);
        }
        let names = |path: &Path| {
            let mut names: Vec<_> = fs::read_dir(path).unwrap().map(|e| e.unwrap().file_name()).collect();
            names.sort();
            names
        };
        assert_eq!(names(dir.path()), ["fluid", "fluid.pvd"]);
        assert_eq!(
            names(&dir.path().join("fluid")),
            ["fluid_000000.vtu", "fluid_000001.vtu", "fluid_000002.vtu"]
        );
    }
}
