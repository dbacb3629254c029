//! The names of this process and of what it uses: <https://wiki.ros.org/Names>, <https://wiki.ros.org/Remapping%20Arguments>.

use std::collections::HashMap;
use std::sync::OnceLock;

/// The names of this process, once it is a node.
static NAMES: OnceLock<Names> = OnceLock::new();

/// What names mean to a node.
#[derive(Debug, Default)]
pub(crate) struct Names {
    /// Of the node, with its namespace: /lab/classifier.
    own: String,
    /// With a slash at its end: /lab/.
    namespace: String,
    /// New names by old ones, both resolved.
    remapped: HashMap<String, String>,
}

/// Names this process `name`, unless its arguments say otherwise; the first call counts.
///
/// # Errors
/// Where the name is none.
pub(crate) fn set(name: &str) -> anyhow::Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let namespace = std::env::var("ROS_NAMESPACE").unwrap_or_default();
    let names = Names::new(name, &namespace, &arguments)?;
    NAMES.get_or_init(|| names);
    Ok(())
}

/// The node's name, with its namespace; "/unnamed" in a process that is no node.
pub(crate) fn own() -> &'static str {
    NAMES.get().map_or("/unnamed", |names| &names.own)
}

/// `name` with its namespace, and remapped as this process was told.
///
/// # Errors
/// Where it is no name.
pub(crate) fn resolve(name: &str) -> anyhow::Result<String> {
    static UNNAMED: OnceLock<Names> = OnceLock::new();
    let names = NAMES.get().unwrap_or_else(|| {
        UNNAMED.get_or_init(|| Names {
            own: "/unnamed".into(),
            namespace: "/".into(),
            ..Names::default()
        })
    });
    names.resolve(name)
}

/// The value of an argument such as `__master:=`.
pub(crate) fn special_argument(name: &str) -> Option<String> {
    let value = |argument: String| argument.strip_prefix(name).map(str::to_owned);
    std::env::args().skip(1).find_map(value)
}

impl Names {
    fn new(name: &str, namespace: &str, arguments: &[String]) -> anyhow::Result<Self> {
        let pairs = || arguments.iter().filter_map(|word| word.split_once(":="));
        let special = |wanted: &str| pairs().find(|(key, _)| *key == wanted).map(|(_, to)| to);
        let name = special("__name").unwrap_or(name);
        anyhow::ensure!(!name.contains('/'), "'{name}' is no name of a node");
        check(name)?;
        let namespace = special("__ns").unwrap_or(namespace).trim_matches('/');
        check(namespace)?;
        let namespace = match namespace {
            "" => "/".to_owned(),
            namespace => format!("/{namespace}/"),
        };
        let own = format!("{namespace}{name}");
        let mut names = Self {
            own,
            namespace,
            remapped: HashMap::new(),
        };
        let remaps = pairs().filter(|(from, _)| !from.starts_with('_'));
        let remapped = remaps.map(|(from, to)| Ok((names.absolute(from)?, names.absolute(to)?)));
        names.remapped = remapped.collect::<anyhow::Result<_>>()?;
        Ok(names)
    }

    fn resolve(&self, name: &str) -> anyhow::Result<String> {
        let name = self.absolute(name)?;
        Ok(self.remapped.get(&name).cloned().unwrap_or(name))
    }

    fn absolute(&self, name: &str) -> anyhow::Result<String> {
        let path = name.trim_start_matches(['/', '~']).trim_end_matches('/');
        check(path)?;
        Ok(match name.chars().next() {
            Some('/') => format!("/{path}"),
            Some('~') => format!("{}/{path}", self.own),
            _ => format!("{}{path}", self.namespace),
        })
    }
}

fn check(path: &str) -> anyhow::Result<()> {
    let is_fine = |letter: char| letter.is_ascii_alphanumeric() || "_/".contains(letter);
    anyhow::ensure!(path.chars().all(is_fine), "'{path}' is no ROS name");
    Ok(())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn names_are_resolved_as_ros_does() {
        let arguments = [
            "__name:=crop",
            "object:=/lab/thing",
            "_radius_m:=0.1",
            "a=b",
        ];
        let names = Names::new("roi_crop", "/left", &arguments.map(str::to_owned)).unwrap();
        assert_eq!(names.own, "/left/crop");
        for (name, resolved) in [
            ("views", "/left/views"),
            ("/tf", "/tf"),
            ("~radius_m", "/left/crop/radius_m"),
            ("object", "/lab/thing"),
            ("/left/object", "/lab/thing"),
            ("object/cloud", "/left/object/cloud"),
        ] {
            assert_eq!(names.resolve(name).unwrap(), resolved);
        }
        assert!(names.resolve("no name").is_err());
        assert!(Names::new("a/b", "", &[]).is_err());
    }
}
