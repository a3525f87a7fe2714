//! A node of ours, and what is left of the dead.

use super::presence::Presence;
use super::room;
use crate::transport::Address;
use crate::{ParticipantError, Result};
use iceoryx2::prelude::{
    Config, FileName, LogLevel, Node, NodeBuilder, Path, SemanticString, SignalHandlingMode,
    set_log_level_from_env_or,
};
use iceoryx2::service::{Service, ipc};
use std::ops::Deref;
use std::sync::mpsc;
use std::thread;
use std::time::Duration;

/// For a node to be made. iceoryx2 waits without a limit for a segment that stays empty.
const CREATION: Duration = Duration::from_secs(4);
/// For another survivor to finish removing what a dead node left.
const CLEAN_UP: Duration = Duration::from_secs(1);

/// A node of ours. Creating one removes what dead nodes of the domain left; the last of a domain to go leaves
/// nothing.
pub(super) struct OwnNode<S: Service + 'static> {
    /// Nothing only while it is dropped, which has to come before the presence ends.
    node: Option<Node<S>>,
    presence: Presence,
}

impl<S: Service + 'static> OwnNode<S> {
    pub(super) fn new(address: &Address) -> Result<Self> {
        let failed = |what: String| ParticipantError::Transport { during: "opening a node".to_owned(), what };
        set_log_level_from_env_or(LogLevel::Fatal);
        let config = config(address).map_err(failed)?;
        room::look(room::FIRST).map_err(failed)?;
        let place = address.root();
        let presence = Presence::enter(address).map_err(|e| failed(format!("{e} ({place})")))?;
        let (send, made) = mpsc::channel();
        let builder = NodeBuilder::new().config(&config).signal_handling_mode(SignalHandlingMode::Disabled);
        let own = address.clone();
        thread::spawn(move || {
            if let Err(late) = send.send(builder.create::<S>()) {
                // Nobody takes a node that comes too late. What it counted with was made after everybody
                // left.
                drop(late);
                drop(Presence::enter(&own));
            }
        });
        let node = made.recv_timeout(CREATION).map_err(|_| {
            let empty = presence.empty_segments().join(", ");
            failed(format!(
                "no node was made in {} s; what others left empty has to be removed: {empty} ({place})",
                CREATION.as_secs()
            ))
        })?;
        let node = node.map_err(|e| failed(format!("{e:?} ({place})")))?;
        presence.keep_private().map_err(|e| failed(format!("{e} ({place})")))?;
        Ok(Self { node: Some(node), presence })
    }

    /// What the names of the domain's segments begin with.
    pub(super) fn prefix(&self) -> &str {
        self.presence.prefix()
    }

    /// Removes what dead nodes left, waiting for others who do the same.
    pub(super) fn clean_up(&self) {
        self.blocking_cleanup_dead_nodes(CLEAN_UP);
    }
}

impl<S: Service + 'static> Deref for OwnNode<S> {
    type Target = Node<S>;

    fn deref(&self) -> &Node<S> {
        self.node.as_ref().expect("the node is there until it is dropped")
    }
}

impl<S: Service + 'static> Drop for OwnNode<S> {
    fn drop(&mut self) {
        self.clean_up();
        self.node = None;
    }
}

/// The library's settings, whole, so that no file in a working or home directory changes them.
fn config(address: &Address) -> Result<Config, String> {
    address.check_domain()?;
    let (root, prefix) = (address.root(), address.prefix());
    let mut config = Config::default();
    config.global.prefix = FileName::new(prefix.as_bytes()).map_err(|e| format!("prefix {prefix}: {e:?}"))?;
    let root = Path::new(root.as_bytes()).map_err(|e| format!("folder {root}: {e:?}"))?;
    config.global.set_root_path(&root);
    Ok(config)
}

/// Removes what processes of the address's domain left in shared memory when they were killed. Who kills
/// participants calls it once they are gone; a run that starts or ends does it by itself.
pub fn remove_stale(address: &Address) -> Result<()> {
    OwnNode::<ipc::Service>::new(address).map(drop)
}
