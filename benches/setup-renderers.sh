#!/bin/sh
# Puts Mitsuba 3, Blender's Cycles and FLIP where the benchmark `renderers` finds them: target/renderers, with a virtual
# environment and a link to LLVM, which Mitsuba compiles its path tracer with. Blender's wheels are for one version of
# Python each: with PYTHON=python3.11 this one is used. Without a wheel for it Cycles is left out.
set -eu
cd "$(dirname "$0")/.."

# LLVM 14 and 15 fail on processors with AVX-512 for half floats, so newer ones alone will do.
llvm() {
    for version in 22 21 20 19 18 17 16; do
        for file in /usr/lib/*/"libLLVM.so.$version".* /usr/lib/*/"libLLVM-$version.so"* \
            /usr/lib64/"libLLVM.so.$version".* "/usr/lib/llvm-$version/lib/libLLVM.so"*; do
            if [ -e "$file" ]; then
                echo "$file"
                return
            fi
        done
    done
}

"${PYTHON:-python3}" -m venv target/renderers
pip="target/renderers/bin/pip install --quiet"
$pip 'mitsuba==3.*,>=3.7' numpy OpenEXR flip-evaluator
$pip 'bpy==5.*' || echo "no Cycles: there is no wheel of bpy 5 for $(target/renderers/bin/python --version)" >&2

found=${DRJIT_LIBLLVM_PATH:-$(llvm)}
if [ -z "$found" ] && [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null; then
    apt-get install --yes --quiet --no-install-recommends libllvm19 >&2 || true
    found=$(llvm)
fi
if [ -n "$found" ]; then
    ln -sf "$found" target/renderers/libLLVM.so
    echo "Mitsuba compiles with $found"
else
    echo "Mitsuba needs LLVM 16 or newer: install Debian's libllvm19, or name another in DRJIT_LIBLLVM_PATH" >&2
fi
