//! Whether the other side lives, and what is left of the dead.

use super::Address;
use super::presence::Presence;
use crate::ParticipantError;
use crate::protocol::MessageHeader;
use iceoryx2::identifiers::UniqueNodeId;
use iceoryx2::prelude::{
    CallbackProgression, Config, LogLevel, Node, NodeBuilder, NodeState, PortFactory as _,
    SignalHandlingMode, set_log_level_from_env_or,
};
use iceoryx2::service::port_factory::publish_subscribe::PortFactory;
use iceoryx2::service::{Service, ipc};
use std::marker::PhantomData;
use std::ops::Deref;
use std::thread::sleep;
use std::time::{Duration, Instant};

/// For another survivor to finish removing what a dead node left.
const CLEAN_UP: Duration = Duration::from_secs(1);
/// For the status of a process that has closed its files.
const STATUS: Duration = Duration::from_millis(200);

/// Says how a process that the caller started has ended (`exit status: 1`), or nothing while it lives.
pub type Alive = Box<dyn FnMut() -> Option<String>>;

/// The process on the other side of a connection.
pub(super) struct Peer<S: Service> {
    node: Option<UniqueNodeId>,
    alive: Option<Alive>,
    end: Option<String>,
    _service: PhantomData<S>,
}

impl<S: Service> Peer<S> {
    pub(super) fn unknown() -> Self {
        Self { node: None, alive: None, end: None, _service: PhantomData }
    }

    /// Asks this of the process that was started, besides looking at its node.
    pub(super) fn watch(&mut self, alive: Alive) {
        self.alive = Some(alive);
    }

    /// Notes whose publisher is on the incoming service, which only the other side's can be.
    pub(super) fn find(&mut self, incoming: &PortFactory<S, [f64], MessageHeader>) {
        if self.node.is_some() {
            return;
        }
        incoming.dynamic_config().list_publishers(|publisher| {
            self.node = Some(publisher.node_id);
            CallbackProgression::Stop
        });
    }

    /// How the other side ended, if that was seen already.
    pub(super) fn end(&self) -> Option<&str> {
        self.end.as_deref()
    }

    /// Looks how the other side ended; nothing while it lives or was never seen.
    pub(super) fn look(&mut self, config: &Config) -> Option<&str> {
        if self.end.is_none() {
            self.end = self.status().or_else(|| {
                let how = self.node_end(config)?;
                // Its files are closed a moment before its status is there, which says more.
                let end = Instant::now() + STATUS;
                while self.alive.is_some() && Instant::now() < end {
                    if let Some(status) = self.status() {
                        return Some(status);
                    }
                    sleep(Duration::from_millis(5));
                }
                Some(how)
            });
        }
        self.end()
    }

    fn status(&mut self) -> Option<String> {
        self.alive.as_mut().and_then(|alive| alive())
    }

    fn node_end(&self, config: &Config) -> Option<String> {
        match Node::<S>::state_of(config, self.node?) {
            Ok(Some(NodeState::Dead(_))) => Some("its node in shared memory is dead".to_owned()),
            Ok(None) => Some("its node in shared memory is gone".to_owned()),
            // A node that cannot be looked at now is looked at again after the next slice of waiting.
            Ok(Some(_)) | Err(_) => None,
        }
    }
}

/// A node of ours. Creating one removes what dead nodes of the domain left; the last of a domain to go leaves
/// nothing.
pub(super) struct OwnNode<S: Service> {
    /// Nothing only while it is dropped, which has to come before the presence ends.
    node: Option<Node<S>>,
    _presence: Presence,
}

impl<S: Service> OwnNode<S> {
    pub(super) fn new(address: &Address) -> Result<Self, ParticipantError> {
        let failed = |what: String| ParticipantError::Transport { during: "opening a node".to_owned(), what };
        set_log_level_from_env_or(LogLevel::Fatal);
        let config = address.config().map_err(failed)?;
        let presence = Presence::enter(address).map_err(|e| failed(format!("{e} ({})", address.root())))?;
        let node = NodeBuilder::new()
            .config(&config)
            .signal_handling_mode(SignalHandlingMode::Disabled)
            .create::<S>()
            .map_err(|e| failed(format!("{e:?} ({})", address.root())))?;
        Ok(Self { node: Some(node), _presence: presence })
    }

    /// Removes what dead nodes left, waiting for others who do the same.
    pub(super) fn clean_up(&self) {
        self.blocking_cleanup_dead_nodes(CLEAN_UP);
    }
}

impl<S: Service> Deref for OwnNode<S> {
    type Target = Node<S>;

    fn deref(&self) -> &Node<S> {
        self.node.as_ref().expect("the node is there until it is dropped")
    }
}

impl<S: Service> Drop for OwnNode<S> {
    fn drop(&mut self) {
        self.clean_up();
        self.node = None;
    }
}

/// Removes what processes of the address's domain left in shared memory when they were killed. Who kills
/// participants calls it once they are gone; a run that starts or ends does it by itself.
pub fn remove_stale(address: &Address) -> Result<(), ParticipantError> {
    OwnNode::<ipc::Service>::new(address).map(drop)
}
