#!/usr/bin/env bash
# One part of a picture: part.sh FOLDER K N SCENE [OPTIONS OF halfdome render]. A part that was begun goes on.
set -euo pipefail
folder=$1 number=$2 parts=$3
shift 3
code=0
halfdome render "$@" --shard "$number/$parts" -o "$folder/$number.hdf" --checkpoint --resume --progress none || code=$?
# A limit (--spp of --noise) that ends a part is no failure.
[ "$code" -eq 0 ] || [ "$code" -eq 4 ]
