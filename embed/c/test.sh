#!/usr/bin/env bash
# The C interface, from C: every program in tests/ and examples/ is compiled as C99 and as C++, linked with the static and
# with the shared library, run, and run again under valgrind. `cargo test` checks that the header is current.
#
# Arguments go on to `cargo build`: with `-p halfdome` the kernel has the renderer's features, and one that was built for that
# is not compiled anew.
#
# On Debian and Ubuntu it installs what is missing (as root, or by sudo): compilers and valgrind.
set -euo pipefail
cd "$(dirname "$0")"

../../.ci/install gcc "gcc libc6-dev" g++ g++ valgrind valgrind

cargo build --release -p halfdome-c "$@"
target=$(cargo metadata --format-version 1 --no-deps | sed 's/.*"target_directory":"\([^"]*\)".*/\1/')/release
out=$(mktemp -d)
trap 'rm -r "$out"' EXIT

warnings="-Wall -Wextra -Werror -pedantic -O1 -g -Iinclude -Itests"
for source in tests/*.c examples/*.c; do
    name=$(basename "$source" .c)
    # shellcheck disable=SC2086
    {
        gcc -std=c99 $warnings "$source" -o "$out/$name-static" "$target/libhalfdome_c.a" -lpthread -ldl -lm
        gcc -std=c99 $warnings "$source" -o "$out/$name-shared" -L"$target" -lhalfdome_c -lpthread -lm
        g++ -std=c++11 -x c++ $warnings "$source" -o "$out/$name-c++" -L"$target" -lhalfdome_c -lpthread -lm
    }
    for program in "$out/$name"-*; do
        echo "== ${program##*/}"
        LD_LIBRARY_PATH=$target "$program"
    done
    echo "== $name in valgrind"
    valgrind --quiet --leak-check=full --show-leak-kinds=all --errors-for-leak-kinds=all --error-exitcode=1 \
        "$out/$name-static" > /dev/null
done

# A shared library for C programs that exports what the header declares, and nothing else.
diff <(nm --dynamic --defined-only "$target/libhalfdome_c.so" | sed 's/.* //' | sort) \
    <(grep -o '\bhd_[a-z_]*(' include/halfdome.h | tr -d '(' | sort -u)
ls -l "$target/libhalfdome_c.a" "$target/libhalfdome_c.so" | awk '{ print "#", $NF, $5, "bytes" }'
echo "The C interface holds."
