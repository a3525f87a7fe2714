//! One side of a connection: send, and wait with a deadline.

mod raw;

use super::peer::{Alive, OwnNode, Peer};
use super::{Address, Traffic};
use crate::ParticipantError;
use crate::protocol::{Kind, MessageHeader, Payload, VERSION, unpack, words};
use iceoryx2::port::{listener::Listener, notifier::Notifier, publisher::Publisher, subscriber::Subscriber};
use iceoryx2::prelude::{AllocationStrategy, BackpressureStrategy, Node, ServiceName};
use iceoryx2::sample::Sample;
use iceoryx2::service::Service;
use iceoryx2::service::port_factory::{event, publish_subscribe};
use std::cell::Cell;
use std::fmt::Debug;
use std::rc::Rc;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// Between two looks at whether the other side lives and the run goes on.
const SLICE: Duration = Duration::from_millis(50);
/// Between two attempts to open services that are not there yet.
const RETRY: Duration = Duration::from_millis(20);
/// Messages that wait in a connection at most: an `Accept` and a `Start`, behind them a `Terminate` or
/// `Goodbye`, and one to spare.
const BUFFER: usize = 4;
/// Doubles of the first segment; larger messages make the sender allocate anew, by powers of two.
const FIRST_LENGTH: usize = 1024;

/// Both directions between the coupler and one participant, seen from one of them.
///
/// The ports stand before the services and those before the node, since that is the order in which they have
/// to be dropped.
pub struct Connection<S: Service> {
    publisher: Publisher<S, [f64], MessageHeader>,
    subscriber: Subscriber<S, [f64], MessageHeader>,
    notifier: Notifier<S>,
    listener: Listener<S>,
    _outgoing: Services<S>,
    incoming: Services<S>,
    peer: Peer<S>,
    node: OwnNode<S>,
    stop: Arc<AtomicBool>,
    meter: Rc<Cell<Traffic>>,
}

/// The services of one direction.
struct Services<S: Service> {
    messages: publish_subscribe::PortFactory<S, [f64], MessageHeader>,
    events: event::PortFactory<S>,
}

impl<S: Service> Connection<S> {
    /// The coupler's side; it creates the services.
    pub fn create(address: &Address, stop: Arc<AtomicBool>) -> Result<Self, ParticipantError> {
        let node = OwnNode::<S>::new(address)?;
        let incoming = create_services(&node, &address.to_coupler())?;
        let outgoing = create_services(&node, &address.to_participant())?;
        Self::over(node, incoming, outgoing, stop)
    }

    /// The participant's side; it opens the services, and waits for them until the deadline, or the end of
    /// the coupler as `alive` tells it.
    pub fn open(
        address: &Address,
        deadline: Duration,
        stop: Arc<AtomicBool>,
        mut alive: Alive,
    ) -> Result<Self, ParticipantError> {
        let node = OwnNode::<S>::new(address)?;
        let end = Instant::now() + deadline;
        let during = || format!("while looking for the coupler of {address}");
        loop {
            let opened = open_services(&node, &address.to_participant())
                .and_then(|incoming| Ok((incoming, open_services(&node, &address.to_coupler())?)));
            match opened {
                Ok((incoming, outgoing)) => {
                    let mut connection = Self::over(node, incoming, outgoing, stop)?;
                    connection.watch(alive);
                    // While it is there: of one that goes before we first look for messages nothing would be
                    // left to know its end by.
                    connection.peer.find(&connection.incoming.messages);
                    return Ok(connection);
                }
                Err(NotOpened::Never(what)) => {
                    return Err(ParticipantError::Transport { during: during(), what });
                }
                Err(NotOpened::NotYet) if stop.load(Ordering::Relaxed) => {
                    return Err(ParticipantError::Interrupted { during: during() });
                }
                Err(NotOpened::NotYet) if Instant::now() >= end => {
                    return Err(ParticipantError::TimedOut {
                        during: during(),
                        seconds: deadline.as_secs_f64(),
                    });
                }
                Err(NotOpened::NotYet) => match alive() {
                    Some(how) => {
                        return Err(ParticipantError::Died { during: format!("{} ({how})", during()) });
                    }
                    None => sleep(RETRY),
                },
            }
        }
    }

    fn over(
        node: OwnNode<S>,
        incoming: Services<S>,
        outgoing: Services<S>,
        stop: Arc<AtomicBool>,
    ) -> Result<Self, ParticipantError> {
        // What receives comes first, so that whoever sees our sender can already be heard.
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
        let meter = Rc::default();
        let peer = Peer::unknown();
        Ok(Self {
            publisher,
            subscriber,
            notifier,
            listener,
            _outgoing: outgoing,
            incoming,
            peer,
            node,
            stop,
            meter,
        })
    }

    /// Asks this of the process on the other side, besides looking at its node.
    pub fn watch(&mut self, alive: Alive) {
        self.peer.watch(alive);
    }

    /// What went through, kept up to date; stays readable after the connection has moved elsewhere.
    pub fn meter(&self) -> Rc<Cell<Traffic>> {
        Rc::clone(&self.meter)
    }

    fn count(&self, add: impl FnOnce(&mut Traffic)) {
        let mut traffic = self.meter.get();
        add(&mut traffic);
        self.meter.set(traffic);
    }

    /// Sends a message, and wakes the other side if `wake`. Does not wait. Counts of the payload are filled
    /// into the header. A field with a value that is not finite is an error ([`ParticipantError::Field`]),
    /// and nothing is sent.
    pub fn send(
        &mut self,
        header: MessageHeader,
        payload: &Payload<'_>,
        wake: bool,
        during: impl Fn() -> String,
    ) -> Result<(), ParticipantError> {
        let started = Instant::now();
        let transport = |what: String| ParticipantError::Transport { during: during(), what };
        let loaned = self.publisher.loan_slice_uninit(payload.len());
        let mut sample = loaned.map_err(|e| transport(format!("no memory: {e:?}")))?;
        *sample.user_header_mut() = MessageHeader {
            scalars: payload.scalars.len() as u64,
            text_bytes: payload.text.len() as u64,
            ..header
        };
        payload.write(sample.payload_mut())?;
        // SAFETY: without an error every double of the payload has been written.
        #[expect(unsafe_code, reason = "zeros in memory that is written right after cost as much as a copy")]
        let sample = unsafe { sample.assume_init() };
        let recipients = sample.send().map_err(|e| transport(format!("not sent: {e:?}")))?;
        if recipients == 0 {
            self.look();
            return Err(match self.peer.end() {
                Some(how) => ParticipantError::Died { during: format!("{} ({how})", during()) },
                None => {
                    transport(format!("nobody takes {}: not connected, or its buffer is full", header.name()))
                }
            });
        }
        if wake {
            self.notifier.notify().map_err(|e| transport(format!("no wake-up: {e:?}")))?;
        }
        self.count(|traffic| {
            traffic.copying_seconds += started.elapsed().as_secs_f64();
            traffic.messages_sent += 1;
            traffic.bytes_sent += 8 * payload.len() as u64;
        });
        Ok(())
    }

    /// Waits for the next message. `during` names what is waited for.
    pub fn receive(
        &mut self,
        deadline: Duration,
        during: impl Fn() -> String,
    ) -> Result<Message<S>, ParticipantError> {
        let started = Instant::now();
        let message = self.wait(started, deadline, &during);
        self.count(|traffic| traffic.waiting_seconds += started.elapsed().as_secs_f64());
        let message = message?;
        self.peer.find(&self.incoming.messages);
        self.count(|traffic| {
            traffic.messages_received += 1;
            traffic.bytes_received += 8 * message.payload().len() as u64;
        });
        message.check().map_err(|what| ParticipantError::Protocol { during: during(), what })?;
        Ok(message)
    }

    fn wait(
        &mut self,
        started: Instant,
        deadline: Duration,
        during: &impl Fn() -> String,
    ) -> Result<Message<S>, ParticipantError> {
        loop {
            if let Some(message) = self.take(during)? {
                return Ok(message);
            }
            // Before the other side's end: what interrupts a run often ends its participants too.
            if self.stop.load(Ordering::Relaxed) {
                return Err(ParticipantError::Interrupted { during: during() });
            }
            if let Some(how) = self.peer.end() {
                return Err(ParticipantError::Died { during: format!("{} ({how})", during()) });
            }
            let Some(left) = deadline.checked_sub(started.elapsed()).filter(|left| !left.is_zero()) else {
                return Err(ParticipantError::TimedOut { during: during(), seconds: deadline.as_secs_f64() });
            };
            // An interrupt by a signal is an empty wake-up: the flag says whether it concerns us.
            let woken = self.listener.timed_wait(|_| {}, left.min(SLICE)).unwrap_or(0);
            if woken == 0 {
                // What it sent before its end is still taken, by the look at the buffer that comes next.
                self.look();
            }
        }
    }

    fn take(&self, during: &impl Fn() -> String) -> Result<Option<Message<S>>, ParticipantError> {
        let received = self.subscriber.receive().map_err(|e| ParticipantError::Transport {
            during: during(),
            what: format!("not received: {e:?}"),
        })?;
        Ok(received.map(Message))
    }

    /// Looks whether the other side has ended. What it left in shared memory is removed.
    fn look(&mut self) {
        self.peer.find(&self.incoming.messages);
        if self.peer.end().is_none() && self.peer.look(self.node.config()).is_some() {
            self.node.clean_up();
        }
    }

    /// Counts time spent on copying a received message.
    pub(crate) fn copied(&self, since: Instant) {
        self.count(|traffic| traffic.copying_seconds += since.elapsed().as_secs_f64());
    }
}

/// A received message; its memory goes back to the sender when it is dropped.
pub struct Message<S: Service>(Sample<S, [f64], MessageHeader>);

impl<S: Service> Message<S> {
    /// Its header.
    pub fn header(&self) -> &MessageHeader {
        self.0.user_header()
    }

    /// Its kind; [`Connection::receive`] refuses messages without one.
    pub fn kind(&self) -> Kind {
        self.header().kind().expect("a message of unknown kind is refused when it is received")
    }

    /// The doubles before the fields.
    pub fn scalars(&self) -> &[f64] {
        &self.payload()[..self.header().scalars as usize]
    }

    /// The doubles of the fields.
    pub fn fields(&self) -> &[f64] {
        let header = self.header();
        &self.payload()[header.scalars as usize..self.payload().len() - words(header.text_bytes as usize)]
    }

    /// The bytes of the text.
    pub fn text(&self) -> Vec<u8> {
        let bytes = self.header().text_bytes as usize;
        unpack(&self.payload()[self.payload().len() - words(bytes)..], bytes)
    }

    /// The text, for people.
    pub fn words(&self) -> String {
        String::from_utf8_lossy(&self.text()).into_owned()
    }

    fn payload(&self) -> &[f64] {
        self.0.payload()
    }

    /// Refuses a header whose counts do not fit the payload, and a kind that this version does not know. A
    /// handshake of another version is let through, for the version to be reported as what it is.
    fn check(&self) -> Result<(), String> {
        let header = self.header();
        let length = self.payload().len() as u64;
        let text = header.text_bytes.div_ceil(8);
        if header.scalars > length || text > length - header.scalars {
            return Err(format!(
                "{} of {length} doubles cannot hold {} scalars and {} bytes of text",
                header.name(),
                header.scalars,
                header.text_bytes
            ));
        }
        match header.kind() {
            Some(Kind::Hello | Kind::Welcome | Kind::Refused) => Ok(()),
            Some(_) if header.version == VERSION => Ok(()),
            Some(_) => Err(format!(
                "{} has protocol version {} where {VERSION} belongs",
                header.name(),
                header.version
            )),
            None => Err(format!("a {} came", header.name())),
        }
    }
}

fn create_services<S: Service>(node: &Node<S>, name: &str) -> Result<Services<S>, ParticipantError> {
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

fn service_name(name: &str) -> Result<ServiceName, ParticipantError> {
    name.try_into().map_err(failed("naming a service"))
}

fn failed<E: Debug>(during: &'static str) -> impl Fn(E) -> ParticipantError {
    move |error| ParticipantError::Transport { during: during.to_owned(), what: format!("{error:?}") }
}
