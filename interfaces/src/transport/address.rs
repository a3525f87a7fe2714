//! Where the two sides of a connection meet.

use crate::Role;
use sha2::{Digest, Sha256};
use std::fmt;
use std::fs;
use std::os::unix::fs::MetadataExt;
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{SystemTime, UNIX_EPOCH};

/// The domain of all runs that do not ask for another.
const DOMAIN: &str = "meniscus";
/// The variable of the environment that names the domain's folder.
pub const FOLDER: &str = "MENISCUS_FOLDER";
/// Longest path (bytes) that a domain's folder and a name that begins with the folder's may have together:
/// the sockets of iceoryx2 stand there, and their paths have 107 bytes at most.
const LONGEST: usize = 68;

/// Where a participant finds its coupler. A process is given it on its command line, as [`Address::connect`]
/// writes it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Address {
    /// Prefix of everything in shared memory. Dead nodes are found and removed within a domain; tests have
    /// their own.
    pub domain: String,
    /// The run, unique among those that run at the same time.
    pub run: String,
    /// The participant's role in it.
    pub role: Role,
}

/// A name for a run that no other has: time and process in it.
pub fn new_run() -> String {
    static RUNS: AtomicU64 = AtomicU64::new(0);
    let now = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |d| d.as_micros());
    format!("{now:x}-{}-{}", std::process::id(), RUNS.fetch_add(1, Ordering::Relaxed))
}

impl Address {
    /// The address of a participant of this run in the usual domain.
    pub fn new(run: impl Into<String>, role: Role) -> Self {
        Self { domain: DOMAIN.to_owned(), run: run.into(), role }
    }

    /// The same in another domain: lower-case letters, digits and `-`.
    pub fn in_domain(self, domain: impl Into<String>) -> Self {
        Self { domain: domain.into(), ..self }
    }

    /// The address that a command line names: `<run>`, or `<domain>/<run>`.
    pub fn parse(connect: &str, role: Role) -> Self {
        match connect.split_once('/') {
            Some((domain, run)) => Self::new(run, role).in_domain(domain),
            None => Self::new(connect, role),
        }
    }

    /// What [`Address::parse`] reads.
    pub fn connect(&self) -> String {
        if self.domain == DOMAIN { self.run.clone() } else { format!("{}/{}", self.domain, self.run) }
    }

    /// Name of the services that carry messages to the participant.
    pub fn to_participant(&self) -> String {
        format!("meniscus/{}/{}/to-participant", self.run, self.role)
    }

    /// Name of the services that carry messages to the coupler.
    pub fn to_coupler(&self) -> String {
        format!("meniscus/{}/{}/to-coupler", self.run, self.role)
    }

    /// The folder of the domain's files that are not in shared memory, this user's alone: `MENISCUS_FOLDER`
    /// where the environment names it, as the coupler does for those whom it starts; else one in
    /// `XDG_RUNTIME_DIR`, where that is fit for it, or in `/tmp`.
    pub fn root(&self) -> String {
        self.root_of(std::env::var(FOLDER).ok(), std::env::var("XDG_RUNTIME_DIR").ok())
    }

    /// [`root`](Self::root) where the environment has this `folder` and this `place` for folders.
    fn root_of(&self, folder: Option<String>, place: Option<String>) -> String {
        let own = self.own();
        let is_own = |folder: &String| {
            Path::new(folder).file_name().is_some_and(|name| name.to_string_lossy().starts_with(&own))
        };
        if let Some(folder) = folder.filter(is_own) {
            return folder;
        }
        if let Some(place) = place.filter(|place| is_fit(Path::new(place))) {
            let place = place.trim_end_matches('/');
            let digest: String = Sha256::digest(place).iter().take(4).map(|b| format!("{b:02x}")).collect();
            let own = format!("{own}-{digest}");
            if place.len() + 2 * own.len() <= LONGEST {
                return format!("{place}/{own}");
            }
        }
        format!("/tmp/{own}")
    }

    /// The prefix of the domain's entries in shared memory, and of its files under [`Address::root`], of
    /// which it is the name: domains that stand in different places have different ones, so that none removes
    /// what is another's.
    pub fn prefix(&self) -> String {
        let root = self.root();
        format!("{}_", root.rsplit('/').next().unwrap_or(&root))
    }

    fn own(&self) -> String {
        format!("{}-{}", self.domain, rustix::process::geteuid().as_raw())
    }

    /// Refuses a domain whose name would be more than the name of a folder.
    pub(super) fn check_domain(&self) -> Result<(), String> {
        // `_` ends a prefix: no domain's is the beginning of another's.
        let sound = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
        if self.domain.is_empty() || self.domain.len() > 32 || !self.domain.chars().all(sound) {
            return Err(format!(
                "`{}` is no domain: 1 to 32 lower-case letters, digits and `-`",
                self.domain
            ));
        }
        Ok(())
    }
}

/// Whether folders of domains can stand there: a directory of this user, by an absolute path, that nobody
/// else can write. (`su` leaves that of another user in the environment.)
fn is_fit(place: &Path) -> bool {
    place.is_absolute()
        && fs::metadata(place).is_ok_and(|there| {
            let own = there.uid() == rustix::process::geteuid().as_raw();
            own && there.is_dir() && there.mode() & 0o022 == 0
        })
}

impl fmt::Display for Address {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the {} of run {}", self.role, self.connect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::fs::PermissionsExt;

    #[test]
    fn an_address_survives_the_command_line() {
        for address in [
            Address::new("5f-1-0", Role::Fluid),
            Address::new("5f-1-0", Role::Structure).in_domain("meniscus-test"),
        ] {
            assert_eq!(Address::parse(&address.connect(), address.role), address);
        }
        assert_eq!(Address::new("5f", Role::Fluid).connect(), "5f");
    }

    #[test]
    fn a_domain_stands_where_nobody_else_writes() {
        let address = Address::new("5f", Role::Fluid).in_domain("gate");
        let folder = tempfile::tempdir().unwrap();
        let place = folder.path().display().to_string();
        let in_place = |mode| {
            fs::set_permissions(&place, fs::Permissions::from_mode(mode)).unwrap();
            address.root_of(None, Some(place.clone()))
        };
        let (own, elsewhere) = (address.own(), format!("/tmp/{}", address.own()));
        let private = in_place(0o700);
        assert!(private.starts_with(&format!("{place}/{own}-")), "{private}");
        assert_eq!(in_place(0o777), elsewhere);
        assert_eq!(address.root_of(None, Some("runtime".to_owned())), elsewhere, "not absolute");
        assert_eq!(address.root_of(None, Some("/no/such/place".to_owned())), elsewhere);
        let long = folder.path().join("a".repeat(100));
        fs::create_dir(&long).unwrap();
        assert_eq!(address.root_of(None, Some(long.display().to_string())), elsewhere, "too long");
        // The coupler's word comes first, for its own domain alone.
        let told = format!("/somewhere/{own}-1234");
        assert_eq!(address.root_of(Some(told.clone()), Some(place.clone())), told);
        assert_eq!(address.root_of(Some("/somewhere/other".to_owned()), None), elsewhere);
    }

    #[test]
    fn runs_have_their_own_names() {
        assert_ne!(new_run(), new_run());
    }

    #[test]
    fn a_domain_that_would_escape_its_folder_is_refused() {
        for domain in ["", "../tmp", "a/b", "Gate", "a_0", "an_unreasonably_long_name_of_a_domain"] {
            assert!(Address::new("run", Role::Fluid).in_domain(domain).check_domain().is_err(), "{domain}");
        }
    }
}
