# make demo [DISPLAY_RVIZ=1]   the whole graph on the simulated robot: eight objects, scanned and named
# make test [JOBS=2]           test-rust (cargo's) and test-graph (the whole system's); JOBS: so many of the latter at once (also test-hosts)
# make test-real               the tests on real scans and captures; DEFORMABLE_COBOT_REAL names their folder
# make test-cluster            datasets made by a Slurm array job, on a Slurm of this one machine
# make test-hosts              a robot and three computers on this one: started by ssh, and everything that goes wrong
# make test-distros            set-up, build, demo and a test on bare Debian 11, 12, 13, and Containerfile, in a chroot each (needs root)
#     [DISTROS="debian-11 debian-13 container"]
# make build                   programs in target/release, ROS package in target/catkin/devel
# make screenshot              README's picture of a scan in RViz, drawn without a screen
# make interface               tables of parameters, topics and services, and the picture of the graph, from the running nodes
# make fault-table             docs/faults.md: what may go wrong and what happens then, from the tests and their last results
# make figures                 docs/figures.md and README's table: how often the shipped model is right, as in training and beyond
#     [SPECIMENS=20 SHIFTED=8 SEEDS=3]   specimens of each class in the two kinds of test; some ten minutes as it is
# make bench                   how fast, how often right; plots in target/bench
# make soak [SCANS=500]        as many scans in a row: no node may grow or slow down; rows in target/soak
# make lint                    formatting, warnings, documentation, spelling, licences and sources of all dependencies
# make audit                   known advisories about dependencies; fetches their database
# make setup                   installs what is missing; the others call it

SHELL := /bin/bash
.SHELLFLAGS := -ec
.ONESHELL:
.PHONY: demo test test-rust test-graph test-real test-cluster test-hosts test-distros fault-table figures build screenshot interface bench soak lint audit setup
.NOTPARALLEL:
.DEFAULT_GOAL := build

# rustup's cargo, even where the shell does not know it yet. A caller's other target folder would hide the programs.
export PATH := $(PATH):$(HOME)/.cargo/bin
unexport CARGO_TARGET_DIR
# ROS's modules are in the system's Python; a pyenv may come first in PATH.
PYTHON := /usr/bin/python3
# In Ubuntu's archive there is none but a snap; the test of scan.html is skipped there.
CHROMIUM := $(if $(filter debian,$(shell . /etc/os-release; echo $$ID)),chromium)
RVIZ := $(if $(wildcard /opt/ros/noetic),ros-noetic-rviz,rviz)

setup:
	setup/install $(if $(DISPLAY_RVIZ),$(RVIZ))

build: setup
	cargo build --release --workspace
	setup/catkin

# Builds only what it runs: without the tools and the training framework.
demo: setup
	@echo 'demo: building the programs of the graph; the first time compiles some 270 libraries, which takes minutes'
	setup/catkin target/catkin deformable_cobot_graph
	echo 'demo: starting the graph on the simulated robot'
	source setup/environment
	$(PYTHON) tests/demo $(if $(DISPLAY_RVIZ),--rviz)

JOBS ?= 1
PYTEST := $(PYTHON) -m pytest $(if $(filter-out 1,$(JOBS)),--numprocesses=$(JOBS))
test: test-rust test-graph

test-rust: build
	cargo test --release --workspace

test-graph: build
	setup/install $(CHROMIUM)
	source setup/environment
	$(PYTEST) --junitxml=target/results/tests.xml tests

REAL := $(or $(DEFORMABLE_COBOT_REAL),$(realpath ../shared/real))
test-real: build
	test -d "$(REAL)" || { echo 'test-real: no real data; let DEFORMABLE_COBOT_REAL name its folder' >&2; exit 1; }
	DEFORMABLE_COBOT_REAL="$(REAL)" cargo test --release --workspace --tests -- --ignored

test-cluster: build
	setup/install munge slurm-client slurmctld slurmd
	$(PYTHON) -m pytest tests/cluster

test-hosts: build
	setup/install iproute2 openssh-server python3-paramiko
	source setup/environment
	$(PYTEST) --junitxml=target/results/hosts.xml tests/hosts

# From the results of the last `make test` and `make test-hosts`.
fault-table:
	$(PYTHON) tests/fault_table.py

# Where the recorded scans are at hand, they are dented anew and measured, too. Seeds by which nothing was chosen.
SPECIMENS := 20
SHIFTED := 8
SEEDS := 3
SCANS_OF_OBJECTS := $(wildcard $(REAL)/scans/*.ply)
DENTED := target/figures/scans-dented-anew
FIGURES := --figures docs/figures.json --summary README.md
figures:
	cargo build --release --workspace --bin evaluate --bin generate_dataset
	mkdir -p target/figures
	rm --recursive --force $(DENTED)
	$(if $(SCANS_OF_OBJECTS),target/release/generate_dataset $(SCANS_OF_OBJECTS:%=--scan %) --out $(DENTED) --count 36 --seed 8101)
	target/release/evaluate --specimens $(SPECIMENS) --seeds $(SEEDS) --seed 8101 $(if $(SCANS_OF_OBJECTS),--dataset $(DENTED)) $(FIGURES)
	target/release/evaluate --shift --specimens $(SHIFTED) --seed 8201 $(FIGURES)

test-distros:
	setup/install debootstrap
	$(PYTHON) tests/distros $(DISTROS)

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
	$(PYTHON) tests/peers/deformation
	$(PYTHON) tests/peers/training
	# Objects taught one after the other, until the model knows twenty: target/bench/taught.png.
	cargo build --release --workspace --example study
	mkdir -p target/bench
	target/release/examples/study --model config/model.onnx --shipped-only --specimens 25 --scans 60 \
		--plot target/bench/taught.png

SCANS := 500
soak: build
	source setup/environment
	$(PYTHON) tests/soak --scans $(SCANS)

DENY := target/lint/bin/cargo-deny
# A folder of its own: whole-system tests that run cargo need not wait for it.
lint: export CARGO_TARGET_DIR := $(CURDIR)/target/lint
lint: $(DENY)
	setup/install shellcheck codespell python3-pyflakes
	cargo fmt --all --check
	cargo clippy --release --workspace --all-targets -- -D warnings
	RUSTDOCFLAGS='-D warnings' cargo doc --release --workspace --no-deps
	shellcheck --exclude=SC1090,SC1091 setup/install setup/onnxruntime setup/catkin launch/dataset.sbatch .ci/run
	shellcheck --shell=bash --exclude=SC1090,SC1091 launch/env_loader.bash
	$(PYTHON) -m pyflakes tests tests/demo tests/distros tests/bench tests/screenshot tests/soak \
		tests/peers/{arap,dataset,deformation,model,reconstruct,registration,scaling,training}
	codespell --skip=target,.git,Cargo.lock,three.js --ignore-words-list=crate
	$(DENY) check --hide-inclusion-graph licenses bans sources

audit: $(DENY)
	$(DENY) check advisories

# Its own release profile (all of it optimised as one) takes longer to build than the rest of the lint.
$(DENY):
	CARGO_PROFILE_RELEASE_LTO=off CARGO_PROFILE_RELEASE_CODEGEN_UNITS=16 CARGO_PROFILE_RELEASE_OPT_LEVEL=0 \
		cargo install --locked --version 0.20.2 --root target/lint cargo-deny
