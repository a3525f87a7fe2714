//! What travels between participants and what is promised: contract, fields, protocol, transport, case file.
