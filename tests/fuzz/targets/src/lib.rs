//! Files for readers that take a path.

use std::path::{Path, PathBuf};
use std::sync::LazyLock;

/// In memory, where the system has such a place: a run of the fuzzer writes thousands a second.
static FOLDER: LazyLock<PathBuf> = LazyLock::new(|| {
    let memory = Path::new("/dev/shm");
    let root = if memory.is_dir() { memory.to_owned() } else { std::env::temp_dir() };
    let folder = root.join(format!("meniscus-fuzz-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    folder
});

/// The folder of the files.
pub fn folder() -> &'static Path {
    &FOLDER
}

/// A file of that name with these bytes.
pub fn file(name: &str, bytes: &[u8]) -> PathBuf {
    let path = FOLDER.join(name);
    std::fs::write(&path, bytes).expect("a file");
    path
}
