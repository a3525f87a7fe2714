#!/usr/bin/env python3
"""A structure in Python: particles of unit reference volume, each on a spring, behind the protocol of docs/protocol.md.

    pip install iceoryx2==0.10.0
    python3 spring_structure.py [--points 5]

`meniscus run` starts it for a case with `[structure.participant] command = ["python3", "…/spring_structure.py"]`, and says
in the environment where its coupler is (MENISCUS_RUN) and which case it runs (MENISCUS_CASE_HASH). Arguments override that.

Each particle obeys  rho x'' = -rho omega^2 (x - X) - grad p  and takes the sub-steps it is told, by leapfrog.
"""

import argparse
import ctypes
import json
import os
import sys
import time

import iceoryx2 as iox2

VERSION = 3
(HELLO, WELCOME, REFUSED, INITIALIZE, READY, START, SOLVED, ACCEPT, SAVE, SAVED, RESTORE, RESTORED, TERMINATE, TERMINATED,
 FAILED, GOODBYE) = range(1, 17)
SLICE = 0.05


class Header(ctypes.Structure):
    _fields_ = [
        ("version", ctypes.c_uint32), ("kind", ctypes.c_uint32), ("sequence", ctypes.c_uint64),
        ("window", ctypes.c_uint64), ("iteration", ctypes.c_uint32), ("sub_steps", ctypes.c_uint32),
        ("time", ctypes.c_double), ("size", ctypes.c_double), ("compute_seconds", ctypes.c_double),
        ("snapshot", ctypes.c_uint64), ("scalars", ctypes.c_uint64), ("text_bytes", ctypes.c_uint64),
    ]

    @staticmethod
    def type_name():
        return "meniscus.MessageHeader"


class Message:
    """A received message, copied out of shared memory."""

    def __init__(self, sample):
        self.header = Header.from_buffer_copy(
            ctypes.string_at(sample.user_header_ptr, ctypes.sizeof(Header)))
        # The payload's own length counts bytes in this version of the package; the header's counts doubles.
        length = sample.header.number_of_elements
        doubles = (ctypes.c_double * length).from_buffer_copy(ctypes.string_at(sample.payload_ptr, 8 * length))
        words = (self.header.text_bytes + 7) // 8
        self.scalars = list(doubles[:self.header.scalars])
        self.fields = list(doubles[self.header.scalars:length - words])
        self.text = bytes(doubles)[8 * (length - words):][:self.header.text_bytes]
        sample.delete()


class Connection:
    """The participant's side."""

    def __init__(self, connect, role, deadline):
        iox2.set_log_level(iox2.LogLevel.Fatal)
        domain, _, run = connect.rpartition("/")
        folder = os.environ.get("MENISCUS_FOLDER", f"/tmp/{domain or 'meniscus'}-{os.geteuid()}")
        self.config = iox2.config.default()
        self.config.global_cfg.prefix = iox2.FileName.new(os.path.basename(folder) + "_")
        self.config.global_cfg.root_path = iox2.Path.new(folder)
        self.node = (iox2.NodeBuilder.new().config(self.config)
                     .signal_handling_mode(iox2.SignalHandlingMode.Disabled).create(iox2.ServiceType.Ipc))
        incoming = self.services(f"meniscus/{run}/{role}/to-participant", deadline)
        outgoing = self.services(f"meniscus/{run}/{role}/to-coupler", deadline)
        self.incoming = incoming[0]
        self.subscriber = incoming[0].subscriber_builder().create()
        self.listener = incoming[1].listener_builder().create()
        self.notifier = outgoing[1].notifier_builder().create()
        self.publisher = (outgoing[0].publisher_builder().initial_max_slice_len(1024)
                          .allocation_strategy(iox2.AllocationStrategy.PowerOfTwo).max_loaned_samples(1)
                          .backpressure_strategy(iox2.BackpressureStrategy.DiscardData).create())

    def services(self, name, deadline):
        end = time.monotonic() + deadline
        name = iox2.ServiceName.new(name)
        while True:
            try:
                messages = (self.node.service_builder(name).publish_subscribe(iox2.Slice[ctypes.c_double])
                            .user_header(Header).open())
                return messages, self.node.service_builder(name).event().open()
            except (iox2.PublishSubscribeOpenError, iox2.EventOpenError):
                if time.monotonic() > end:
                    raise SystemExit(f"no coupler is listening at {name}")
                time.sleep(0.02)

    def send(self, kind, scalars=(), fields=(), text=b"", **header):
        text_bytes = len(text)
        text += bytes(-text_bytes % 8)
        length = len(scalars) + len(fields) + len(text) // 8
        sample = self.publisher.loan_slice_uninit(length)
        head = Header(version=VERSION, kind=kind, scalars=len(scalars), text_bytes=text_bytes, **header)
        ctypes.memmove(sample.user_header_ptr, ctypes.byref(head), ctypes.sizeof(head))
        doubles = (ctypes.c_double * (length - len(text) // 8))(*scalars, *fields)
        ctypes.memmove(sample.payload_ptr, bytes(doubles) + text, 8 * length)
        if sample.assume_init().send() != 1:
            raise SystemExit("the coupler is gone")
        self.notifier.notify()

    def receive(self, deadline):
        end = time.monotonic() + deadline
        gone = False
        while True:
            sample = self.subscriber.receive()
            if sample is not None:
                return Message(sample)
            if gone:
                self.node.blocking_cleanup_dead_nodes(iox2.Duration.from_secs(1))
                raise SystemExit("the coupler died")
            if time.monotonic() > end:
                raise SystemExit(f"the coupler was silent for {deadline} s")
            if not self.listener.timed_wait(iox2.Duration.from_secs_f64(SLICE)):
                gone = not self.coupler_lives()

    def coupler_lives(self):
        """Whether a node besides ours has the service open and is alive."""
        return any(isinstance(state, iox2.NodeState.Alive) and state[0].id != self.node.id for state in self.incoming.nodes)


class Springs:
    """Two doubles a particle, in every list."""

    def __init__(self, points, density=1000.0, omega=20.0):
        self.density, self.omega = density, omega
        self.reference = [0.1 * i for i in range(2 * points)]
        self.position, self.velocity = list(self.reference), [0.0] * (2 * points)
        self.solved = None

    def solve(self, size, sub_steps, load):
        """From the accepted state, which stays as it is."""
        position, velocity = list(self.position), list(self.velocity)
        sub_steps = sub_steps or max(1, int(size * self.omega / 0.1) + 1)
        dt = size / sub_steps
        for _ in range(sub_steps):
            for i, (reference, gradient) in enumerate(zip(self.reference, load)):
                def acceleration(x):
                    return -self.omega ** 2 * (x - reference) - gradient / self.density
                half = velocity[i] + 0.5 * dt * acceleration(position[i])
                position[i] += dt * half
                velocity[i] = half + 0.5 * dt * acceleration(position[i])
        self.solved = position, velocity
        return sub_steps

    def accept(self):
        self.position, self.velocity = self.solved

    def energy(self, position, velocity):
        return 0.5 * self.density * sum(
            v * v + self.omega ** 2 * (x - r) ** 2 for x, v, r in zip(position, velocity, self.reference))


def description(points):
    def port(name, unit, components, direction, exchange):
        return {"name": name, "quantity": name.replace("_", "-"), "unit": unit, "components": components, "points": points,
                "direction": direction, "exchange": exchange, "required": True}
    return {"role": "structure", "solver": "springs in Python", "dimension": 2, "saves": True,
            "ports": [port("position", "m", 2, "out", "every-window"),
                      port("velocity", "m/s", 2, "out", "every-window"),
                      port("reference_volume", "m3", 1, "out", "constant"),
                      port("density", "kg/m3", 1, "out", "constant"),
                      port("pressure_gradient", "Pa/m", 2, "in", "every-window")],
            "scalars": [{"name": "energy", "unit": "J", "kind": "balance"}]}


def serve(connection, springs, points, request):
    """Answers requests until `Terminate`; returns the number of the last one."""
    infinite, pieces = float("inf"), b""
    while True:
        message = connection.receive(request)
        head, number = message.header, message.header.sequence
        if head.kind == GOODBYE:
            raise SystemExit("the coupler ended the run early")
        if head.kind == INITIALIZE:
            if message.scalars != [points] * 5:
                raise ValueError(f"there are {points} points, not {message.scalars}")
            fields = springs.position + springs.velocity + [1.0] * points + [springs.density] * points
            connection.send(READY, [springs.energy(springs.position, springs.velocity)], fields, sequence=number, size=infinite)
        elif head.kind == START:
            if len(message.fields) != 2 * points:
                raise ValueError(f"{len(message.fields)} doubles came where {2 * points} belong")
            started = time.monotonic()
            taken = springs.solve(head.size, head.sub_steps, message.fields)
            position, velocity = springs.solved
            connection.send(SOLVED, [springs.energy(position, velocity)], position + velocity, sequence=number, window=head.window,
                            iteration=head.iteration, sub_steps=taken, size=infinite,
                            compute_seconds=time.monotonic() - started)
        elif head.kind == ACCEPT:
            springs.accept()
        elif head.kind == SAVE:
            state = json.dumps([springs.position, springs.velocity]).encode()
            connection.send(SAVED, text=state, sequence=number, snapshot=len(state))
        elif head.kind == RESTORE:
            # A state over 4 MiB comes in pieces.
            pieces = (pieces if head.window else b"") + message.text
            if len(pieces) < head.snapshot:
                connection.send(RESTORED, sequence=number)
                continue
            springs.position, springs.velocity = json.loads(pieces)
            connection.send(RESTORED, [springs.energy(springs.position, springs.velocity)],
                            springs.position + springs.velocity, sequence=number, size=infinite)
        elif head.kind == TERMINATE:
            connection.send(TERMINATED, sequence=number)
            return
        else:
            raise ValueError(f"message of kind {head.kind} is no request")


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    for argument, variable in (("--connect", "MENISCUS_RUN"), ("--case-hash", "MENISCUS_CASE_HASH")):
        told = os.environ.get(variable)
        arguments.add_argument(argument, default=told, required=told is None, help=f"{variable} where it is left out")
    arguments.add_argument("--points", type=int, default=5)
    arguments.add_argument("--hello-deadline", type=float, default=30.0)
    arguments.add_argument("--answer-deadline", type=float, default=60.0)
    given = arguments.parse_args()
    request = given.hello_deadline + 2 * given.answer_deadline

    connection = Connection(given.connect, "structure", given.hello_deadline)
    hello = {"case_hash": given.case_hash, "description": description(given.points)}
    connection.send(HELLO, text=json.dumps(hello).encode())
    answer = connection.receive(given.hello_deadline)
    if answer.header.kind == REFUSED:
        connection.send(GOODBYE)
        raise SystemExit("the coupler refused the handshake:\n" + answer.text.decode())
    welcome = json.loads(answer.text)
    if answer.header.version != VERSION or welcome != {"case_hash": given.case_hash, "dimension": 2}:
        raise SystemExit(f"the coupler has version {answer.header.version} and {welcome}")
    failure = None
    try:
        serve(connection, Springs(given.points), given.points, request)
    except Exception as error:
        failure = f"{type(error).__name__}: {error}"
        connection.send(FAILED, text=failure.encode())
    while connection.receive(request).header.kind != GOODBYE:
        pass
    sys.exit(failure)


if __name__ == "__main__":
    main()
