# Common tasks; `just` lists them. Everything also works without just: the commands are those of the README and CONTRIBUTING.

set shell := ["bash", "-euo", "pipefail", "-c"]

# List the recipes.
default:
    @just --list

# Formatting and lints, without tests.
check:
    cargo fmt --all --check
    cargo clippy --release --workspace --all-targets --locked -- -D warnings
    cargo clippy --release --workspace --exclude whole-chain --lib --bins --locked -- -D warnings -D clippy::unwrap_used

# The libraries' own tests and examples: under two minutes after a build.
test-fast:
    cargo test --release --locked --workspace --exclude whole-chain --lib --doc

# All tests, the Python ones included.
test:
    cargo test --release --workspace --locked

# Record the snapshots of messages, tables and descriptions again; read the diff.
snapshots:
    INSTA_UPDATE=always cargo test --release --locked -p whole-chain

# The API documentation, with warnings denied.
docs:
    RUSTDOCFLAGS="-D warnings" cargo doc --release --workspace --no-deps --locked

# Benchmarks of one package, such as `just bench cofferdam-dam`.
bench package:
    cargo bench --locked -p {{ package }}

# What a change must pass.
ci:
    .ci/run

# The command and the libraries of the FMUs, in target/release.
release:
    cargo build --release --locked

# The documents as a book with search, in target/book; needs `cargo install mdbook`.
book:
    mdbook build docs

# A wheel with the Python package, the command and the libraries of the FMUs, in target/wheel.
wheel:
    cargo build --release --locked
    COFFERDAM_PROGRAMS="$PWD/target/release" python3 -m pip wheel --no-deps --wheel-dir target/wheel ./python
