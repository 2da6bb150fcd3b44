#!/bin/sh
# Puts Embree 4.4 where the benchmark `peers` finds it: the wheel of the PyPI package embreex holds the library.
set -eu
cd "$(dirname "$0")/.."
python3 -m venv target/peers
target/peers/bin/pip install --quiet 'embreex==4.4.*'
echo "Embree is in $(find target/peers -name 'libembree4*' | head -n 1)"
