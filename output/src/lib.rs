//! The files a run leaves, and the report made from them.
