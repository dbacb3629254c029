//! A ROS 1 node: start-up, parameters, topics, services, time, TF, health and shutdown.
//!
//! A node's `main` calls [`run`] with a body that sets up its topics and waits for shutdown. Messages are encoded and decoded
//! by rosrust's generated code, after their lengths have been checked. The rest of the protocol is here, since the arm
//! must come to rest whatever happens to a peer or to the network:
//!
//! | what happens | what is done | tried by |
//! |---|---|---|
//! | who asked for a motion dies, hangs up or is unplugged | its [`Life`] ends within 3 s, through all nodes that the request went through | `hosts/test_callers.py` |
//! | a node is told to end | each [`Life`] ends, requests are answered, results sent; 3 s at most | `test_ends.py` |
//! | a connection is lost | it is made again while the master lists the publisher | `test_a_lost_link_is_dialled_again` |
//! | a listener's computer is cut off for less than a minute | its connection is kept, but for commands and results | `test_main_computer_unplugged_in_a_long_turn` |
//! | the master is restarted | the node registers again; connections go on | `test_a_restarted_master_learns_of_the_node_again` |
//! | a peer is mute, stopped or slow | it has a task and time limits of its own; others do not wait for it | `test_a_listener_that_stands_still_holds_up_nobody`, `test_hostile_peer` |
//! | a peer announces more bytes than it sends, or sends garbage | the message is refused before memory is taken for it | `test_a_forged_length_does_not_abort` |
//! | somebody takes up all connections | idle ones make room; those in use are counted for each computer | `test_capacity.py` |
//! | somebody listens late | the last message of a latched topic comes once | `test_late_listeners_get_a_latched_message_once` |
//! | time goes back (a bag that loops) | [`Clock::jumps`], and TF is forgotten | `test_a_looping_bag_starts_afresh_each_time` |
//! | no address of the computer is set | [`environment`] requires it | `test_a_bad_environment_is_named` |
//! | another computer's clock is wrong | it is named, and no view is taken | `test_clock_stepped` |
//! | a panic, or SIGKILL | the process ends, roslaunch starts it again, and it takes up its parameters | `test_kills.py` |

pub mod environment;
pub mod transforms;

mod bounded;
mod callers;
mod clock;
mod clock_skew;
mod count;
#[cfg(test)]
mod fuzz;
mod graph;
mod health;
mod inbox;
mod layout;
mod life;
mod listener;
mod logging;
mod master;
mod memory;
mod message_kind;
mod names;
mod node;
mod parameters;
mod peers;
mod publication;
mod publisher;
mod registration;
mod run;
mod service_client;
mod service_server;
mod shutdown;
mod subscriber;
mod subscription;
mod tcpros;
mod tuning;
mod xmlrpc;

pub use clock::Clock;
pub use clock_skew::ClockOffset;
pub use count::Count;
pub use health::{Health, Level};
pub use life::Life;
pub use listener::Transforms;
pub use node::{Node, compute};
pub use parameters::ParameterError;
pub use peers::{PeerClock, Peers, Source, Unreachable};
pub use publication::Latch;
pub use publisher::Publisher;
pub use run::{run, run_program};
pub use service_client::CallError;
pub use service_server::{Answer, Handler, Server};
pub use subscriber::Subscriber;
pub use subscription::Expect;
pub use tuning::Tuned;
