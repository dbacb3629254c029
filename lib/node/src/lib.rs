//! The one place that touches rosrust: start-up, parameters, topics, services, time, TF, health and shutdown.
//!
//! A node's `main` calls [`run`] with a body that sets up its topics and waits for shutdown. What rosrust 0.9.12 does
//! wrong is put right here, once:
//!
//! | rosrust | remedy |
//! |---|---|
//! | never redials a lost publisher | [`Subscriber`] redials when its topic is silent |
//! | allocates any array length that arrives | [`bounded`] checks lengths first |
//! | unregisters before it stops, blocks on the master | [`run`] lets the body stop motion first, and does not wait long |
//! | registers with the master once | a watch registers again after the master was restarted |
//! | latching unknown to rosbag | [`Latch::Yes`] repeats each second |
//! | service calls wait for ever | [`Node::call`] has a deadline, and hangs up when it is dropped |
//! | services do not see their callers die | a server of our own, and [`Life`] |
//! | one mute caller keeps all others from a service | that server serves all at once, and counts them |
//! | waits for mute, stopped and unplugged peers | time limits on all sockets |
//! | no notion of time going back | [`Clock::jumps`], and TF is forgotten |
//! | never asks publishers for TCP_NODELAY | acknowledges each message at once |
//! | address of the computer guessed | [`environment`] requires it |
//! | a panic ends one callback in silence | the process aborts, roslaunch starts it again |
//! | tickers replay missed ticks in a burst | use `tokio::time::interval` with `MissedTickBehavior::Skip` |

pub mod bounded;
pub mod environment;
pub mod layout;
pub mod transforms;

mod acknowledgement;
mod callers;
mod clock;
mod health;
#[cfg(test)]
mod hostile;
mod life;
mod link;
mod listener;
mod listeners;
mod logging;
mod master;
mod memory;
mod node;
mod offset;
mod parameters;
mod peers;
mod publisher;
mod service;
mod service_client;
mod service_server;
mod shutdown;
mod sockets;
mod subscriber;
mod supervisor;
mod tcp_info;
mod tcpros;
mod tuning;
mod xmlrpc;

pub use clock::Clock;
pub use health::{Health, Level};
pub use life::Life;
pub use listener::Transforms;
pub use node::{Node, compute, run, run_program};
pub use offset::ClockOffset;
pub use parameters::ParameterError;
pub use peers::{PeerClock, Peers, Source, Unreachable};
pub use publisher::{Latch, Publisher};
pub use service::{CallError, Server};
pub use service_server::{Answer, Handler};
pub use subscriber::{Expect, Subscriber};
pub use tuning::Tuned;
