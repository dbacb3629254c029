# make demo [DISPLAY_RVIZ=1]   the whole graph on the simulated robot: eight objects, scanned and named
# make test                    all tests but those of a cluster and of several hosts
# make test-cluster            datasets made by a Slurm array job, on a Slurm of this one machine
# make test-hosts              a robot and three computers on this one: started by ssh, and everything that goes wrong
# make build                   programs in target/release, ROS package in target/catkin/devel
# make screenshot              README's picture of a scan in RViz, drawn without a screen
# make interface               tables of parameters, topics and services, and the picture of the graph, from the running nodes
# make bench                   how fast, how often right; plots in target/bench
# make soak [SCANS=500]        as many scans in a row: no node may grow or slow down; rows in target/soak
# make lint                    formatting, warnings, documentation, spelling, licences and sources of all dependencies
# make audit                   known advisories about dependencies; fetches their database
# make setup                   installs what is missing; the others call it

SHELL := /bin/bash
.SHELLFLAGS := -ec
.ONESHELL:
.PHONY: demo test test-cluster test-hosts build screenshot interface bench soak lint audit setup
.DEFAULT_GOAL := build

# rustup's cargo, even where the shell does not know it yet. A caller's other target folder would hide the programs.
export PATH := $(PATH):$(HOME)/.cargo/bin
unexport CARGO_TARGET_DIR
# ROS's modules are in the system's Python; a pyenv may come first in PATH.
PYTHON := /usr/bin/python3
RVIZ := $(if $(wildcard /opt/ros/noetic),ros-noetic-rviz,rviz)

setup:
	setup/install $(if $(DISPLAY_RVIZ),$(RVIZ))

build: setup
	cargo build --release --workspace
	setup/catkin

demo: build
	source setup/environment
	$(PYTHON) tests/demo $(if $(DISPLAY_RVIZ),--rviz)

test: build
	cargo test --release --workspace
	source setup/environment
	$(PYTHON) -m pytest tests

test-cluster: build
	setup/install munge slurm-client slurmctld slurmd
	$(PYTHON) -m pytest tests/cluster

test-hosts: build
	setup/install iproute2 openssh-server python3-paramiko
	source setup/environment
	$(PYTHON) -m pytest tests/hosts

screenshot: build
	setup/install $(RVIZ) xvfb imagemagick
	source setup/environment
	$(PYTHON) tests/screenshot config/scan.png

interface: build
	setup/install graphviz
	source setup/environment
	$(PYTHON) tests/interface.py

bench: build
	source setup/environment
	$(PYTHON) tests/bench
	setup/install python3-venv libusb-1.0-0 libgl1 libgomp1
	$(PYTHON) tests/peers/arap
	$(PYTHON) tests/peers/reconstruct
	$(PYTHON) tests/peers/dataset
	$(PYTHON) tests/peers/scaling
	$(PYTHON) tests/peers/model
	$(PYTHON) tests/peers/registration
	$(PYTHON) tests/peers/training

SCANS := 500
soak: build
	source setup/environment
	$(PYTHON) tests/soak --scans $(SCANS)

DENY := target/lint/bin/cargo-deny
lint: $(DENY)
	setup/install shellcheck codespell python3-pyflakes
	cargo fmt --all --check
	cargo clippy --release --workspace --all-targets -- -D warnings
	RUSTDOCFLAGS='-D warnings' cargo doc --release --workspace --no-deps
	shellcheck --exclude=SC1090,SC1091 setup/install setup/onnxruntime setup/catkin launch/dataset.sbatch .ci/run
	shellcheck --shell=bash --exclude=SC1090,SC1091 launch/env_loader.bash
	$(PYTHON) -m pyflakes tests tests/demo tests/bench tests/screenshot tests/soak \
		tests/peers/{arap,dataset,model,reconstruct,registration,scaling,training}
	codespell --skip=target,.git,Cargo.lock --ignore-words-list=crate
	$(DENY) check --hide-inclusion-graph licenses bans sources

audit: $(DENY)
	$(DENY) check advisories

$(DENY):
	cargo install --locked --version 0.20.2 --root target/lint cargo-deny
