#!/usr/bin/env bash
# One picture by Slurm: slurm.sh SCENE OUTPUT PARTS [OPTIONS OF halfdome render]
# An array of jobs, and a job that merges when all have succeeded. Jobs that are sent away go on with their checkpoints.
# The nodes must see this folder, which keeps the parts in OUTPUT.parts. Options of sbatch go into SBATCH_PARTITION and
# the like.
set -euo pipefail
scene=$1 output=$2 parts=$3
shift 3
here=$(cd "$(dirname "$0")" && pwd)
folder=$output.parts
mkdir -p "$folder"
before=$(printf '%q ' "$here/part.sh" "$folder")
after=$(printf '%q ' "$parts" "$scene" "$@")
array=$(sbatch --parsable --requeue --array "1-$parts" --output "$folder/%a.log" \
    --wrap "$before \$SLURM_ARRAY_TASK_ID $after")
sbatch --parsable --dependency "afterok:$array" --kill-on-invalid-dep yes --output "$folder/merge.log" \
    --wrap "halfdome merge $(printf '%q' "$folder")/*.hdf -o $(printf '%q' "$output")"
