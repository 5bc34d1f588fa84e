#!/usr/bin/env bash
# A mesh in bricks by SLURM's array jobs, on one machine: starts munged, slurmctld and slurmd of its own (as root; Debian: apt install
# slurm-wlm), submits the lines that `rvachev plan` prints, and waits for the merge.
#
# Exit code 3: SLURM is missing or does not come up; others are those of rvachev and sbatch.
#
# usage: slurm.sh RVACHEV PART SIZE BRICKS SHARES FOLDER
#   e.g. slurm.sh target/release/rvachev part.py 0.03 2x2x2 3 /tmp/job
set -euo pipefail
rvachev=$(realpath "$1") part=$(realpath "$2") size=$3 bricks=$4 shares=$5
mkdir -p "$6"
folder=$(realpath "$6")
for need in munged slurmctld slurmd sbatch; do
    command -v $need >/dev/null || { echo "$need is missing: apt install slurm-wlm munge" >&2; exit 3; }
done
[ "$(id -u)" = 0 ] || { echo "slurmctld and slurmd are started here, which needs root" >&2; exit 3; }

# A cluster of one node that is this machine, all of its files in the folder.
host=$(hostname -s)
mkdir -p "$folder"/{state,spool,munge,log}
key=$folder/munge/key socket=$folder/munge/socket
head -c 1024 /dev/urandom >"$key"
chmod 700 "$folder/munge" && chmod 400 "$key"
munged --force --key-file "$key" --socket "$socket" --pid-file "$folder/munge/pid" \
    --log-file "$folder/munge/log" --seed-file "$folder/munge/seed" || exit 3
port=$((20000 + RANDOM % 20000))
cat >"$folder/slurm.conf" <<CONF
ClusterName=bricks
SlurmctldHost=$host(127.0.0.1)
SlurmUser=root
SlurmctldPort=$port
SlurmdPort=$((port + 1))
AuthType=auth/munge
AuthInfo=socket=$socket
CredType=cred/munge
ProctrackType=proctrack/pgid
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SwitchType=switch/none
ReturnToService=2
StateSaveLocation=$folder/state
SlurmdSpoolDir=$folder/spool
SlurmctldPidFile=$folder/slurmctld.pid
SlurmdPidFile=$folder/slurmd.pid
SlurmctldLogFile=$folder/log/slurmctld
SlurmdLogFile=$folder/log/slurmd
MpiDefault=none
NodeName=$host NodeAddr=127.0.0.1 CPUs=$(nproc) State=UNKNOWN
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
CONF
export SLURM_CONF=$folder/slurm.conf
stop() {
    for pid in slurmd.pid slurmctld.pid munge/pid; do
        [ -f "$folder/$pid" ] && kill "$(cat "$folder/$pid")" 2>/dev/null || true
    done
}
trap stop EXIT
slurmctld || exit 3
slurmd || exit 3
up=
for _ in $(seq 60); do
    sinfo -h -o %T 2>/dev/null | grep -q idle && up=yes && break
    sleep 0.5
done
[ -n "$up" ] || { echo "SLURM does not come up here:" >&2; tail -n 5 "$folder"/log/slurm* >&2; exit 3; }
sinfo
timeout 60 sbatch --wait --chdir="$folder" --output="$folder/log/probe" --wrap=true ||
    { echo "SLURM runs no jobs here" >&2; exit 3; }

cd "$folder"
"$rvachev" plan "$part" --size "$size" --bricks "$bricks" -o job -q
array() {
    sbatch --parsable --chdir="$folder" --output="$folder/log/round$1-%a" --array="1-$shares" ${2:+--dependency=afterok:$2} \
        --wrap="'$rvachev' brick job --threads 1 --round $1 --share \$SLURM_ARRAY_TASK_ID/$shares"
}
first=$(array 1)
second=$(array 2 "$first")
third=$(array 3 "$second")
sbatch --wait --chdir="$folder" --output="$folder/log/merge" --dependency="afterok:$third" \
    --wrap="'$rvachev' merge job -o merged.stl --report merged.json"
cat "$folder/log/merge"
