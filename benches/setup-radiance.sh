#!/bin/sh
# Puts Radiance where the benchmark `irradiance_curves` finds it: the wheel of the PyPI package pyradiance holds its
# programs. Goes into target/radiance.
set -eu
cd "$(dirname "$0")/.."
"${PYTHON:-python3}" -m venv target/radiance
target/radiance/bin/pip install --quiet 'pyradiance==1.*'
echo "Radiance is in $(dirname "$(find target/radiance -name rtrace | head -n 1)")"
