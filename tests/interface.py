#!/usr/bin/python3
"""Writes launch/README.md and config/README.md: what the running nodes say of their topics, services and parameters."""

import argparse
import pathlib
import re
import subprocess
import sys
import tempfile

from graph import Core, Graph
from processes import wait_until

CHECKOUT = pathlib.Path(__file__).resolve().parent.parent
GRAPH_FILE, PARAMETERS_FILE, PICTURE = 'launch/README.md', 'config/README.md', 'launch/graph.svg'
MADE = 'Made from the running nodes by `make interface`; a test compares it with them.'
# What every node has, or ROS itself.
COMMON = re.compile(r'/(rosout.*|clock|diagnostics|.*/(get_loggers|set_logger_level))$')


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.parse_args()
    with tempfile.TemporaryDirectory(prefix='deformable_cobot-') as folder:
        core = Core(pathlib.Path(folder))
        try:
            core.start()
            parameters = parameters_page(core)
            graph = RunningGraph(core)
        finally:
            core.stop()
    (CHECKOUT / PARAMETERS_FILE).write_text(parameters)
    (CHECKOUT / GRAPH_FILE).write_text(graph.page())
    picture = subprocess.run(['dot', '-Tsvg'], input=graph.dot(), stdout=subprocess.PIPE, text=True, check=True)
    (CHECKOUT / PICTURE).write_text(picture.stdout)
    print(f'written: {PARAMETERS_FILE}, {GRAPH_FILE}, {PICTURE}')


class RunningGraph:
    """Who publishes, hears and serves what, by the ROS master."""

    def __init__(self, core):
        import rosgraph
        self.core = core
        self.master = rosgraph.Master('/interface')
        self.nodes, self.links, self.types = [], [], {}
        self.graph = Graph(core, 'sim.launch')
        for service in ('scan_object', 'classify_cloud', 'rotate_wrist'):
            self.graph.wait_for_service(service, timeout_s=60)
        # Links appear one after the other while the nodes start.
        wait_until(lambda: not self.look(), 60, 'a graph that no longer changes', period_s=2)

    def look(self):
        """Asks the master; returns whether anything is new."""
        import rosservice
        before = self.links
        # Clouds are heard only while views are taken, and shortly after.
        self.graph.call('capture_views', timeout_s=60, angles=[0.0])
        self.nodes = sorted(name for name in self.core.nodes() if name.strip('/') in nodes_with_parameters())
        state = dict(zip(('publishes', 'hears', 'serves'), self.master.getSystemState()))
        self.links = sorted((what, name, node) for what, entries in state.items() for name, nodes in entries
                            for node in nodes if node in self.nodes and not COMMON.match(name))
        self.types = dict(self.master.getTopicTypes())
        self.types.update((name, rosservice.get_service_type(name)) for what, name, _ in self.links if what == 'serves')
        return self.links != before

    def page(self):
        lines = ['# The running graph', '', f'{MADE} It is that of `sim.launch`.', '',
                 f'![nodes and topics]({pathlib.Path(PICTURE).name})', '',
                 'Each node also publishes `/diagnostics` each second.']
        for node in self.nodes:
            lines += ['', f'## {node.strip("/")}', '', '| | name | type |', '|---|---|---|']
            lines += [f'| {what} | `{name}` | `{self.types.get(name, "")}` |'
                      for what, name, owner in self.links if owner == node]
        return '\n'.join(lines) + '\n'

    def dot(self):
        """Nodes, and an arrow for each topic from who publishes to who hears; for graphviz."""
        lines = ['digraph {', 'rankdir=LR; node [shape=box, style=rounded, fontname="sans-serif", fontsize=11];',
                 'edge [fontname="sans-serif", fontsize=9, color="#606060"];']
        heard = {}
        for what, name, node in self.links:
            heard.setdefault(name, {'publishes': [], 'hears': [], 'serves': []})[what].append(node.strip('/'))
        for name, of in heard.items():
            if name not in ('/tf', '/tf_static'):
                lines += [f'"{source}" -> "{target}" [label="{name.lstrip("/")}"];'
                          for source in of['publishes'] for target in of['hears'] if source != target]
        return '\n'.join(lines + ['}']) + '\n'


def nodes_with_parameters():
    """Folder of each node's crate by the node's name."""
    manifests = [*CHECKOUT.glob('nodes/*/Cargo.toml'), *CHECKOUT.glob('sim/*/Cargo.toml')]
    programs = {re.search(r'\[\[bin\]\]\nname = "(\w+)"', path.read_text()): path.parent for path in manifests}
    return {found[1]: folder for found, folder in programs.items()
            if found and re.search(r'\.parameters\(', sources(folder))}


def sources(folder):
    return '\n'.join(path.read_text() for path in sorted(folder.glob('src/**/*.rs')))


def parameters_page(core):
    lines = ['# Parameters', '', f'{MADE}', '',
             'Private parameters of each node, their defaults, and what they mean. `NODE.yaml` in this folder holds what differs '
             'from the defaults;', '`rosparam get /NODE` shows all that are in force. An unknown name or a value out of range '
             'stops the node with a message.']
    for node, folder in sorted(nodes_with_parameters().items()):
        lines += ['', f'## {node}', '', '| parameter | default | |', '|---|---|---|']
        lines += [f'| `{name}` | {shown(default)} | {text} |' for name, default, text in parameters(core, node, folder)]
    return '\n'.join(lines) + '\n'


def shown(value):
    if isinstance(value, str):
        return f'`{value}`' if value else 'empty'
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float):
        return f'{value:.6g}'
    if isinstance(value, list):
        return '[' + ', '.join(shown(entry) for entry in value) + ']'
    return str(value)


def parameters(core, node, folder):
    """(name, default, meaning) of each parameter: defaults from the running node, the rest from its sources."""
    import rospy
    source = sources(folder)
    root = re.search(r'\.parameters\((\w+)::validate\)', source)[1]
    structs = dict(re.findall(r'pub struct (\w+) \{\n(.*?)\n\}', source, re.DOTALL))
    wanted = [name for name, _, _ in fields(structs[root])]
    program = core.run(CHECKOUT / 'target/release' / node)
    try:
        wait_until(lambda: set(wanted) <= set(rospy.get_param(f'/{node}', {})), 20, f'parameters of {node}')
        return list(rows(structs, root, rospy.get_param(f'/{node}'), ''))
    finally:
        program.stop()


def rows(structs, struct, values, prefix):
    for name, text, kind in fields(structs[struct]):
        if kind in structs and isinstance(values[name], dict):
            yield from rows(structs, kind, values[name], f'{prefix}{name}/')
        elif isinstance(values[name], dict):  # a type of another crate
            yield from ((f'{prefix}{name}/{key}', value, text) for key, value in sorted(values[name].items()))
        else:
            yield prefix + name, values[name], text


def fields(body):
    """(name, documentation, type) of a Rust struct's public fields."""
    found = re.findall(r'((?:^ *///.*\n)*)(?:^ *#\[.*\n)*^ *pub (\w+): ([\w:<>\[\]; ]+)', body, re.MULTILINE)
    return [(name, ' '.join(line.strip().removeprefix('///').strip() for line in text.splitlines()), kind)
            for text, name, kind in found]


if __name__ == '__main__':
    sys.exit(main())
