//! The master's list of services. rosrust registers only servers of its own making.

use crate::{environment, xmlrpc};
use std::io;
use std::time::Duration;

/// How long the master has to answer.
const DEADLINE: Duration = Duration::from_secs(2);

/// Lists the service `name` at `uri` (rosrpc://HOST:PORT), in place of any other of that name.
pub(crate) fn register_service(name: &str, uri: &str) -> io::Result<()> {
    let arguments = [&rosrust::name()[..], name, uri, &rosrust::uri()];
    call("registerService", &arguments).map(drop)
}

/// Takes the service `name` at `uri` from the list.
pub(crate) fn unregister_service(name: &str, uri: &str) -> io::Result<()> {
    call("unregisterService", &[&rosrust::name(), name, uri]).map(drop)
}

/// Where the service `name` is: host and port. `None` where nobody offers it.
pub(crate) fn lookup_service(name: &str) -> io::Result<Option<String>> {
    let answer = call("lookupService", &[&rosrust::name(), name])?;
    Ok(rosrpc_address(&answer).map(str::to_owned))
}

fn call(method: &str, arguments: &[&str]) -> io::Result<String> {
    xmlrpc::call(&environment::master_uri(), method, arguments, DEADLINE)
}

/// Host and port in an answer that has a service's URI. The master's words quote it before it comes as the value.
fn rosrpc_address(answer: &str) -> Option<&str> {
    let (_, rest) = answer.rsplit_once("rosrpc://")?;
    let address = rest.split(['<', '/']).next()?;
    let (_, port) = address.rsplit_once(':')?;
    port.parse::<u16>().is_ok().then_some(address)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_are_found_in_answers() {
        let answer = |uri: &str| {
            format!(
                "<string>rosrpc URI: [{uri}]</string></value><value><string>{uri}</string></value>"
            )
        };
        let found = answer("rosrpc://arm:4711/");
        assert_eq!(rosrpc_address(&found), Some("arm:4711"));
        assert_eq!(
            rosrpc_address(&answer("rosrpc://10.0.0.2:80")),
            Some("10.0.0.2:80")
        );
        let quoted = "<string>rosrpc URI: [rosrpc://10.0.0.2:80]</string>";
        let found = format!("{quoted}{}", answer("rosrpc://10.0.0.2:80"));
        assert_eq!(rosrpc_address(&found), Some("10.0.0.2:80"));
        assert_eq!(rosrpc_address(&answer("rosrpc://arm")), None);
        assert_eq!(rosrpc_address(&answer("unknown service")), None);
    }
}
