//! Checks of the environment before a node starts: its address, the master's, and whether the master answers.

use crate::names::{self, special_argument};
use crate::xmlrpc;
use std::net::{Ipv4Addr, ToSocketAddrs, UdpSocket};
use std::time::{Duration, Instant};
use thiserror::Error;

/// How long the master has to answer at the start of a node.
const MASTER_DEADLINE: Duration = Duration::from_secs(1);
/// How long a node waits for the master: roslaunch starts both together.
const MASTER_WAIT: Duration = Duration::from_secs(10);
const MASTER_POLL: Duration = Duration::from_millis(200);

/// What is wrong with the environment, and the remedy.
#[derive(Debug, Error, PartialEq)]
pub enum EnvironmentError {
    /// Neither ROS_IP nor ROS_HOSTNAME is set, and no route leads to the master.
    #[error(
        "neither ROS_IP nor ROS_HOSTNAME is set, and this computer has no route to the ROS master at {0}, which would tell its \
         address; see to ROS_MASTER_URI and the network, or run `export ROS_IP=<address of this computer>`"
    )]
    NoAddress(String),
    /// ROS_IP is no address.
    #[error(
        "ROS_IP is '{0}', which is no IPv4 address; run `export ROS_IP=<address of this computer>`"
    )]
    BadAddress(String),
    /// ROS_HOSTNAME does not resolve.
    #[error("ROS_HOSTNAME is '{0}', which this computer cannot resolve; use ROS_IP instead")]
    UnknownHost(String),
    /// ROS_MASTER_URI is no URI of a master.
    #[error("ROS_MASTER_URI is '{0}'; it must look like http://HOST:11311")]
    BadMaster(String),
    /// No master answers.
    #[error("no ROS master answers at {0}; start roscore there or set ROS_MASTER_URI")]
    NoMaster(String),
}

/// Checks the addresses in the environment and waits until the master accepts connections.
///
/// Returns this computer's name or address, as others are told.
///
/// # Errors
/// Names what is wrong and the remedy.
pub async fn check() -> Result<String, EnvironmentError> {
    let argument = special_argument("__hostname:=").or_else(|| special_argument("__ip:="));
    let host = match argument {
        Some(host) => host,
        None => address(
            variable("ROS_IP").as_deref(),
            variable("ROS_HOSTNAME").as_deref(),
            &master_uri(),
        )?,
    };
    wait_for_master(&master_uri(), Instant::now() + MASTER_WAIT).await?;
    Ok(host)
}

/// Where the master is.
pub(crate) fn master_uri() -> String {
    special_argument("__master:=")
        .or_else(|| variable("ROS_MASTER_URI"))
        .unwrap_or_else(|| "http://localhost:11311".into())
}

fn variable(name: &str) -> Option<String> {
    std::env::var(name).ok().filter(|value| !value.is_empty())
}

/// What is set, or the address by which this computer reaches the master. The computer's name, which ROS's own libraries take, is
/// often one that other computers cannot resolve.
fn address(
    ip: Option<&str>,
    hostname: Option<&str>,
    master: &str,
) -> Result<String, EnvironmentError> {
    match (hostname, ip) {
        (Some(name), _) => match (name, 0).to_socket_addrs().map(|mut found| found.next()) {
            Ok(Some(_)) => Ok(name.into()),
            _ => Err(EnvironmentError::UnknownHost(name.into())),
        },
        (None, Some(ip)) => ip
            .parse::<Ipv4Addr>()
            .map(|_| ip.into())
            .map_err(|_| EnvironmentError::BadAddress(ip.into())),
        (None, None) => towards(master).ok_or_else(|| EnvironmentError::NoAddress(master.into())),
    }
}

/// This computer's IPv4 address on its route to the master; nothing is sent.
fn towards(master: &str) -> Option<String> {
    let socket = UdpSocket::bind((Ipv4Addr::UNSPECIFIED, 0)).ok()?;
    socket.connect(xmlrpc::authority(master)?).ok()?;
    Some(socket.local_addr().ok()?.ip().to_string())
}

async fn wait_for_master(uri: &str, deadline: Instant) -> Result<(), EnvironmentError> {
    xmlrpc::authority(uri).ok_or_else(|| EnvironmentError::BadMaster(uri.into()))?;
    while xmlrpc::call(uri, "getPid", &[names::own().into()], MASTER_DEADLINE)
        .await
        .is_err()
    {
        if Instant::now() > deadline {
            return Err(EnvironmentError::NoMaster(uri.into()));
        }
        tokio::time::sleep(MASTER_POLL).await;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bad_address_is_named() {
        let of = |ip, hostname| address(ip, hostname, "http://localhost:11311");
        assert_eq!(of(Some("127.0.0.1"), None), Ok("127.0.0.1".into()));
        assert_eq!(
            of(Some("main"), None),
            Err(EnvironmentError::BadAddress("main".into()))
        );
        assert_eq!(of(None, Some("localhost")), Ok("localhost".into()));
        let unknown = "no-such-host.invalid";
        assert_eq!(
            of(Some("127.0.0.1"), Some(unknown)),
            Err(EnvironmentError::UnknownHost(unknown.into()))
        );
    }

    #[test]
    fn without_a_setting_the_address_is_the_one_towards_the_master() {
        let of = |master: &str| address(None, None, master);
        assert_eq!(of("http://localhost:11311"), Ok("127.0.0.1".into()));
        assert_eq!(of("http://127.0.0.2:11311/"), Ok("127.0.0.1".into()));
        let lost = "http://no-such-host.invalid:11311";
        assert_eq!(of(lost), Err(EnvironmentError::NoAddress(lost.into())));
    }

    #[tokio::test]
    async fn a_missing_master_is_named() {
        let soon = Instant::now();
        for bad in [
            "localhost:11311",
            "http://localhost",
            "http://localhost:port",
        ] {
            assert_eq!(
                wait_for_master(bad, soon).await,
                Err(EnvironmentError::BadMaster(bad.into()))
            );
        }
        // A port that was free a moment ago.
        let port = std::net::TcpListener::bind("127.0.0.1:0")
            .and_then(|listener| listener.local_addr())
            .map_or(1, |address| address.port());
        let uri = format!("http://127.0.0.1:{port}/");
        assert_eq!(
            wait_for_master(&uri, soon).await,
            Err(EnvironmentError::NoMaster(uri))
        );
    }
}
