//! Links over iceoryx2: between processes by shared memory, and within one process.
//!
//! Names and settings of the services are in `docs/protocol.md`. Everything a run leaves in shared memory
//! belongs to a *node*, one a connection and side. Whoever finds a dead node removes what it left: the
//! survivors of a run when they notice, and any later run of the same user when it starts. The last of a
//! domain to go, or the first to come, removes what no node accounts for: `presence`.

mod node;
mod presence;
mod private;
mod room;

pub use node::remove_stale;

use super::Address;
use super::link::{During, Link, Received};
use crate::protocol::{MessageHeader, Payload};
use crate::{ParticipantError, Result};
use iceoryx2::identifiers::UniqueNodeId;
use iceoryx2::port::{listener::Listener, notifier::Notifier, publisher::Publisher, subscriber::Subscriber};
use iceoryx2::prelude::{
    AllocationStrategy, BackpressureStrategy, CallbackProgression, Node, NodeState, PortFactory as _,
    ServiceName, ZeroCopySend,
};
use iceoryx2::sample::Sample;
use iceoryx2::service::port_factory::{event, publish_subscribe};
use iceoryx2::service::{Service, ipc, local};
use node::OwnNode;
use std::fmt::Debug;
use std::time::Duration;

/// Messages that wait in a connection at most: an `Accept` and a `Start`, behind them a `Terminate` or
/// `Goodbye`, and one to spare.
const BUFFER: usize = 4;
/// Doubles of the first segment; larger messages make the sender allocate anew, by powers of two.
const FIRST_LENGTH: usize = 1024;

/// Between processes.
pub type SharedMemory = Ports<ipc::Service>;
/// Within one process.
pub type WithinProcess = Ports<local::Service>;

// SAFETY: plain numbers in C's layout, without gaps, as a test of the protocol holds it to.
#[expect(unsafe_code, reason = "only this transport knows that the header travels through shared memory")]
unsafe impl ZeroCopySend for MessageHeader {
    unsafe fn type_name() -> &'static str {
        "meniscus.MessageHeader"
    }
}

/// The ports of one side, both ways.
///
/// The ports stand before the services and those before the node, since that is the order in which they have
/// to be dropped.
pub struct Ports<S: Service + 'static> {
    publisher: Publisher<S, [f64], MessageHeader>,
    subscriber: Subscriber<S, [f64], MessageHeader>,
    notifier: Notifier<S>,
    listener: Listener<S>,
    _outgoing: Services<S>,
    incoming: Services<S>,
    node: OwnNode<S>,
    /// The node on the other side, once it was seen.
    peer: Option<UniqueNodeId>,
    /// Doubles of a message for which there is room in shared memory.
    longest: usize,
}

/// The services of one direction.
struct Services<S: Service> {
    messages: publish_subscribe::PortFactory<S, [f64], MessageHeader>,
    events: event::PortFactory<S>,
}

impl<S: Service + 'static> Ports<S> {
    fn over(node: OwnNode<S>, incoming: Services<S>, outgoing: Services<S>) -> Result<Self> {
        // What receives comes first, so that whoever sees our sender can already be heard.
        room::look(room::FIRST).map_err(no_room)?;
        let subscriber =
            incoming.messages.subscriber_builder().create().map_err(failed("creating a subscriber"))?;
        let listener = incoming.events.listener_builder().create().map_err(failed("creating a listener"))?;
        let notifier = outgoing.events.notifier_builder().create().map_err(failed("creating a notifier"))?;
        let publisher = outgoing
            .messages
            .publisher_builder()
            .initial_max_slice_len(FIRST_LENGTH)
            .allocation_strategy(AllocationStrategy::PowerOfTwo)
            .max_loaned_samples(1)
            .backpressure_strategy(BackpressureStrategy::DiscardData)
            .create()
            .map_err(failed("creating a publisher"))?;
        room::reserve(node.prefix()).map_err(no_room)?;
        Ok(Self {
            publisher,
            subscriber,
            notifier,
            listener,
            _outgoing: outgoing,
            incoming,
            node,
            peer: None,
            longest: FIRST_LENGTH,
        })
    }

    /// Notes whose publisher is on the incoming service, which only the other side's can be.
    fn find_peer(&mut self) {
        if self.peer.is_none() {
            self.incoming.messages.dynamic_config().list_publishers(|publisher| {
                self.peer = Some(publisher.node_id);
                CallbackProgression::Stop
            });
        }
    }
}

impl<S: Service + 'static> Link for Ports<S> {
    type Received = Sample<S, [f64], MessageHeader>;

    fn create(address: &Address) -> Result<Self> {
        let node = OwnNode::<S>::new(address)?;
        let incoming = create_services(&node, &address.to_coupler())?;
        let outgoing = create_services(&node, &address.to_participant())?;
        Self::over(node, incoming, outgoing)
    }

    fn open(address: &Address, again: &mut dyn FnMut() -> Result<()>) -> Result<Self> {
        let node = OwnNode::<S>::new(address)?;
        loop {
            let opened = open_services(&node, &address.to_participant())
                .and_then(|incoming| Ok((incoming, open_services(&node, &address.to_coupler())?)));
            match opened {
                Ok((incoming, outgoing)) => {
                    let mut ports = Self::over(node, incoming, outgoing)?;
                    // While it is there: of one that goes before we first look for messages nothing would be
                    // left to know its end by.
                    ports.find_peer();
                    return Ok(ports);
                }
                Err(NotOpened::Never(what)) => {
                    let during = format!("while looking for the coupler of {address}");
                    return Err(ParticipantError::Transport { during, what });
                }
                Err(NotOpened::NotYet) => again()?,
            }
        }
    }

    fn send(&mut self, header: &MessageHeader, payload: &Payload<'_>, during: During<'_>) -> Result<bool> {
        let failed = |what: String| ParticipantError::Transport { during: during(), what };
        if payload.len() > self.longest {
            room::look(room::of_messages(payload.len())).map_err(failed)?;
        }
        let loaned = self.publisher.loan_slice_uninit(payload.len());
        let mut sample = loaned.map_err(|e| failed(format!("no memory: {e:?}")))?;
        if payload.len() > self.longest {
            room::reserve(self.node.prefix()).map_err(failed)?;
            self.longest = payload.len();
        }
        *sample.user_header_mut() = *header;
        payload.write(sample.payload_mut())?;
        // SAFETY: without an error every double of the payload has been written.
        #[expect(unsafe_code, reason = "zeros in memory that is written right after cost as much as a copy")]
        let sample = unsafe { sample.assume_init() };
        let recipients = sample.send().map_err(|e| failed(format!("not sent: {e:?}")))?;
        Ok(recipients > 0)
    }

    fn wake(&self, during: During<'_>) -> Result<()> {
        let failed = |e| ParticipantError::Transport { during: during(), what: format!("no wake-up: {e:?}") };
        self.notifier.notify().map(drop).map_err(failed)
    }

    fn take(&mut self, during: During<'_>) -> Result<Option<Self::Received>> {
        let failed =
            |e| ParticipantError::Transport { during: during(), what: format!("not received: {e:?}") };
        let received = self.subscriber.receive().map_err(failed)?;
        if received.is_some() {
            self.find_peer();
        }
        Ok(received)
    }

    fn wait(&mut self, at_most: Duration) -> bool {
        self.listener.timed_wait(|_| {}, at_most).is_ok_and(|woken| woken > 0)
    }

    fn peer_end(&mut self) -> Option<String> {
        self.find_peer();
        match Node::<S>::state_of(self.node.config(), self.peer?) {
            Ok(Some(NodeState::Dead(_))) => Some("its node in shared memory is dead".to_owned()),
            Ok(None) => Some("its node in shared memory is gone".to_owned()),
            // A node that cannot be looked at now is looked at again after the next slice of waiting.
            Ok(Some(_)) | Err(_) => None,
        }
    }

    fn clean_up(&self) {
        self.node.clean_up();
    }
}

impl<S: Service> Received for Sample<S, [f64], MessageHeader> {
    fn header(&self) -> &MessageHeader {
        self.user_header()
    }

    fn payload(&self) -> &[f64] {
        self
    }
}

fn create_services<S: Service>(node: &Node<S>, name: &str) -> Result<Services<S>> {
    let name = service_name(name)?;
    let messages = node
        .service_builder(&name)
        .publish_subscribe::<[f64]>()
        .user_header::<MessageHeader>()
        .enable_safe_overflow(false)
        .history_size(0)
        .subscriber_max_buffer_size(BUFFER)
        .subscriber_max_borrowed_samples(1)
        .max_publishers(1)
        .max_subscribers(1)
        .max_nodes(2)
        .create()
        .map_err(failed("creating a service; is the run's name unique?"))?;
    let events = node
        .service_builder(&name)
        .event()
        .max_notifiers(1)
        .max_listeners(1)
        .max_nodes(2)
        .event_id_max_value(0)
        .create()
        .map_err(failed("creating an event service; is the run's name unique?"))?;
    Ok(Services { messages, events })
}

/// Why services were not opened.
enum NotOpened {
    /// They are not there, or not whole yet.
    NotYet,
    /// They are there, and not for us.
    Never(String),
}

fn open_services<S: Service>(node: &Node<S>, name: &str) -> Result<Services<S>, NotOpened> {
    use iceoryx2::service::builder::{
        event::EventOpenError, publish_subscribe::PublishSubscribeOpenError as Open,
    };
    let name = service_name(name).map_err(|e| NotOpened::Never(e.to_string()))?;
    let messages = node
        .service_builder(&name)
        .publish_subscribe::<[f64]>()
        .user_header::<MessageHeader>()
        .open()
        .map_err(|error| match error {
            Open::DoesNotExist
            | Open::Interrupt
            | Open::HangsInCreation
            | Open::ServiceInCorruptedState
            | Open::IsMarkedForDestruction => NotOpened::NotYet,
            Open::IncompatibleTypes => NotOpened::Never(
                "the coupler's messages have another layout: it is of another version".to_owned(),
            ),
            Open::ExceedsMaxNumberOfNodes => {
                NotOpened::Never("another participant is connected in this role".to_owned())
            }
            error => NotOpened::Never(format!("{error:?}")),
        })?;
    let events = node.service_builder(&name).event().open().map_err(|error| match error {
        EventOpenError::DoesNotExist
        | EventOpenError::Interrupt
        | EventOpenError::HangsInCreation
        | EventOpenError::ServiceInCorruptedState
        | EventOpenError::IsMarkedForDestruction => NotOpened::NotYet,
        error => NotOpened::Never(format!("{error:?}")),
    })?;
    Ok(Services { messages, events })
}

fn no_room(what: String) -> ParticipantError {
    ParticipantError::Transport { during: "opening a connection".to_owned(), what }
}

fn service_name(name: &str) -> Result<ServiceName> {
    name.try_into().map_err(failed("naming a service"))
}

fn failed<E: Debug>(during: &'static str) -> impl Fn(E) -> ParticipantError {
    move |error| ParticipantError::Transport { during: during.to_owned(), what: format!("{error:?}") }
}
