//! Whether the other side lives, and what is left of the dead.

use super::Address;
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
use std::time::Duration;

/// For another survivor to finish removing what a dead node left.
const CLEAN_UP: Duration = Duration::from_secs(1);

/// Says how a process that the caller started has ended (`exit status: 1`), or nothing while it lives.
pub type Alive = Box<dyn FnMut() -> Option<String>>;

/// The process on the other side of a connection.
pub(super) struct Peer<S: Service> {
    node: Option<UniqueNodeId>,
    alive: Option<Alive>,
    _service: PhantomData<S>,
}

impl<S: Service> Peer<S> {
    pub(super) fn unknown() -> Self {
        Self { node: None, alive: None, _service: PhantomData }
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

    /// How the other side ended, or nothing while it lives or was never seen.
    pub(super) fn ended(&mut self, config: &Config) -> Option<String> {
        if let Some(how) = self.alive.as_mut().and_then(|alive| alive()) {
            return Some(how);
        }
        match Node::<S>::state_of(config, self.node?) {
            Ok(Some(NodeState::Dead(_))) => Some("its node in shared memory is dead".to_owned()),
            Ok(None) => Some("its node in shared memory is gone".to_owned()),
            // A node that cannot be looked at now is looked at again after the next slice of waiting.
            Ok(Some(_)) | Err(_) => None,
        }
    }
}

/// A node of ours; creating one removes what dead nodes of the domain left.
pub(super) fn node<S: Service>(address: &Address) -> Result<Node<S>, ParticipantError> {
    let failed = |what: String| ParticipantError::Transport { during: "opening a node".to_owned(), what };
    set_log_level_from_env_or(LogLevel::Fatal);
    let config = address.config().map_err(failed)?;
    NodeBuilder::new()
        .config(&config)
        .signal_handling_mode(SignalHandlingMode::Disabled)
        .create::<S>()
        .map_err(|e| failed(format!("{e:?} ({})", address.root())))
}

/// Removes what dead nodes left, waiting for others who do the same.
pub(super) fn clean_up<S: Service>(node: &Node<S>) {
    node.blocking_cleanup_dead_nodes(CLEAN_UP);
}

/// Removes what processes of the address's domain left in shared memory when they were killed. Who kills participants calls it
/// once they are gone; a run that starts or ends does it by itself.
pub fn remove_stale(address: &Address) -> Result<(), ParticipantError> {
    clean_up(&node::<ipc::Service>(address)?);
    Ok(())
}
