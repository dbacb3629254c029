"""The tables of parameters, topics and services say what the running nodes say."""

import pytest

import interface

pytestmark = [pytest.mark.built, pytest.mark.timeout(180)]


def test_parameters_are_as_written(core, checkout):
    written = (checkout / interface.PARAMETERS_FILE).read_text()
    assert interface.parameters_page(core) == written, f'{interface.PARAMETERS_FILE} is out of date: make interface'


def test_topics_and_services_are_as_written(core, checkout):
    written = (checkout / interface.GRAPH_FILE).read_text()
    assert interface.RunningGraph(core).page() == written, f'{interface.GRAPH_FILE} is out of date: make interface'
