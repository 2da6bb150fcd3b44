#!/usr/bin/env bash
# One picture by GNU parallel, HyperQueue and Slurm (a cluster of this machine) has the bytes of a single run, though Slurm
# kills a part once and starts it again. Installs the schedulers (Debian, as root), except where they are there.
set -euo pipefail
cd "$(dirname "$0")/.."
cargo build --release -p halfdome
PATH=$PWD/target/release:$PATH
farm=$PWD/docs/farm

command -v parallel slurmctld munged >/dev/null || apt-get install -y -q parallel slurm-wlm munge
work=$(mktemp -d)
stop() {
    for name in d ctld; do [ ! -f "$work/$name.pid" ] || kill "$(cat "$work/$name.pid")" || true; done
    rm -rf "$work"
}
trap stop EXIT
python3 -m venv "$work/python"
"$work/python/bin/pip" -q install hyperqueue
cd "$work"

export SOURCE_DATE_EPOCH=0
options=(--size 320x240 --spp 1024 --noise 4%)
halfdome render cornell "${options[@]}" -o whole.exr --progress none || [ $? -eq 4 ]

same() {
    cmp "$1" whole.exr
    printf '%s: the same bytes\n' "$1"
}

"$farm/parallel.sh" cornell parallel.exr 5 "${options[@]}"
same parallel.exr
"$work/python/bin/python" "$farm/hq_render.py" --local cornell hyperqueue.exr 3 "${options[@]}"
same hyperqueue.exr

export SHELL=/bin/bash
bake=(bake cornell --size 64 --spp 8 --mode direct --progress none)
halfdome "${bake[@]}" -o whole.obj
seq 5 | parallel --halt soon,fail=1 --quote halfdome "${bake[@]}" --shard {}/5 -o part{}.state
halfdome merge part*.state -o shared.obj.state
halfdome "${bake[@]}" -o shared.obj --resume
cmp shared-0.exr whole-0.exr
printf 'the bake: the same bytes\n'
printf '0.278 0.001 0.279 0 1 0\n0.1 0.2 0.3 1 0 0\n0.3 0.4 0.1 0 0 1\n' >points.txt
sensors=(irradiance cornell --points points.txt --spp 16 --progress none)
halfdome "${sensors[@]}" -o whole.txt
seq 2 | parallel --halt soon,fail=1 --quote halfdome "${sensors[@]}" --shard {}/2 -o part{}.txt
halfdome merge part*.txt -o shared.txt
cmp shared.txt whole.txt
printf 'sensors: the same bytes\n'

mkdir state spool
cat >slurm.conf <<CONF
ClusterName=one
SlurmctldHost=$(hostname)
AuthType=auth/munge
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SlurmUser=$(id -un)
StateSaveLocation=$work/state
SlurmdSpoolDir=$work/spool
SlurmctldPidFile=$work/ctld.pid
SlurmdPidFile=$work/d.pid
SlurmctldLogFile=$work/ctld.log
SlurmdLogFile=$work/d.log
ReturnToService=2
NodeName=$(hostname) CPUs=$(nproc) State=UNKNOWN
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
CONF
export SLURM_CONF=$work/slurm.conf
if ! munge -n >/dev/null 2>&1; then
    mkdir -p /run/munge
    chown munge: /run/munge
    su -s /bin/sh munge -c munged
fi
slurmctld
slurmd
until sinfo -h -t idle -o %n | grep -q .; do sleep 1; done
"$farm/slurm.sh" cornell slurm.exr 3 "${options[@]}"
# A part that is sent away in the middle goes on.
until squeue -h -r -t running -o %A | grep -q .; do sleep 0.2; done
squeue -h -r -t running -o %A | head -n 1 | xargs -r scontrol requeue || true
for _ in $(seq 300); do
    [ ! -f slurm.exr ] || break
    sleep 1
done
same slurm.exr
