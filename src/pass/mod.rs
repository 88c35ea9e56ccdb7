//! One file a GPU pass: what it binds and how it is dispatched, nothing else.
