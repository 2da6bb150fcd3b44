#!/usr/bin/env bash
# One picture by GNU parallel: parallel.sh SCENE OUTPUT PARTS [OPTIONS OF halfdome render]
# For other machines, add --sshloginfile and the like by the variable PARALLEL; all must see this folder.
set -euo pipefail
scene=$1 output=$2 parts=$3
shift 3
here=$(cd "$(dirname "$0")" && pwd)
folder=$(mktemp -d "$PWD/farm.XXXXXX")
trap 'rm -rf "$folder"' EXIT
seq "$parts" | parallel --halt soon,fail=1 --quote "$here/part.sh" "$folder" {} "$parts" "$scene" "$@"
halfdome merge "$folder"/*.hdf -o "$output"
