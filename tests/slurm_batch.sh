#!/usr/bin/env bash
# Runs the job array of `muspin batch --plan` on a Slurm of this machine, kills one node in the middle, and collects the table.
#
# usage: tests/slurm_batch.sh [VARIANTS [NODES]]      (default 200 variants on 2 nodes of one processor each)
#
# Needs Debian's packages slurm-wlm and munge (`apt-get install slurm-wlm munge`), and root, because slurmd starts jobs. Exit 77 says that something of this is missing. Nothing is installed and no configuration of the system is touched:
# munged, slurmctld and one slurmd a node run from a temporary folder and are ended with it. The program is that of the
# environment variable MUSPIN, by default target/release/muspin.
#
# A variant is a design without the polish and without a PID (`--quick --no-polish`).
set -euo pipefail
cd "$(dirname "$0")/.."
variants=${1:-200}
nodes=${2:-2}
muspin=$(realpath "${MUSPIN:-target/release/muspin}")
for program in munged mungekey slurmctld slurmd sbatch squeue sinfo scontrol; do
    command -v "$program" > /dev/null || { echo "missing: $program (apt-get install slurm-wlm munge)"; exit 77; }
done
[ "$(id -u)" -eq 0 ] || { echo "missing: root, to start slurmd"; exit 77; }
[ -x "$muspin" ] || { echo "missing: $muspin (cargo build --release)"; exit 77; }

place=$(mktemp -d /tmp/muspin-slurm.XXXXXX)
chmod 755 "$place"
mkdir "$place/bin" "$place/state"
ln -s "$muspin" "$place/bin/muspin"
export PATH="$place/bin:$PATH" SLURM_CONF="$place/slurm.conf"
finish() {
    # Only what was started here: daemons by the files with their numbers, jobs through Slurm.
    scancel --state=PENDING --name=muspin 2> /dev/null || true
    scancel --name=muspin 2> /dev/null || true
    for file in "$place"/slurmd-*.pid "$place/slurmctld.pid" "$place/munged.pid"; do
        [ -f "$file" ] || continue
        daemon=$(cat "$file")
        kill "$daemon" 2> /dev/null || continue
        # The controller saves its state before it ends.
        for _ in $(seq 50); do [ -f "$file" ] && kill -0 "$daemon" 2> /dev/null || break; sleep 0.1; done
    done
    [ "${KEEP:-}" ] || rm -rf "$place" || true
}
trap finish EXIT

# The key and the socket of an authentication of its own.
mungekey --create --keyfile="$place/munge.key"
munged --force --key-file="$place/munge.key" --socket="$place/munge.socket" --pid-file="$place/munged.pid" \
    --log-file="$place/munged.log" --seed-file="$place/munge.seed" 2> "$place/munged.err"

host=$(hostname -s)
{
    cat << CONFIGURATION
ClusterName=one
SlurmctldHost=$host(127.0.0.1)
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=socket=$place/munge.socket
CryptoType=crypto/munge
SlurmctldPort=26817
SlurmctldPidFile=$place/slurmctld.pid
SlurmctldLogFile=$place/slurmctld.log
StateSaveLocation=$place/state
SlurmdPidFile=$place/slurmd-%n.pid
SlurmdLogFile=$place/slurmd-%n.log
SlurmdSpoolDir=$place/spool-%n
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MpiDefault=none
JobAcctGatherType=jobacct_gather/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerParameters=sched_interval=2
MaxArraySize=2000
JobRequeue=1
# A node that is silent for so many seconds is down, and its jobs go back into the queue.
SlurmdTimeout=15
ReturnToService=2
CONFIGURATION
    for node in $(seq "$nodes"); do
        echo "NodeName=n$node NodeHostname=$host NodeAddr=127.0.0.1 Port=$((26820 + node)) CPUs=1 State=UNKNOWN"
    done
    echo "PartitionName=all Nodes=n[1-$nodes] Default=YES MaxTime=INFINITE State=UP"
} > "$SLURM_CONF"
slurmctld
for node in $(seq "$nodes"); do
    mkdir -p "$place/spool-n$node"
    slurmd -N "n$node"
done
for _ in $(seq 30); do
    [ "$(sinfo --noheader --states=idle --format=%D | head -1)" = "$nodes" ] && break
    sleep 1
done
sinfo --long

# The plan: two tools that meet the specification, and as many variations as give the number of variants asked for; the array
# takes the first of them. (A tool that misses it is followed by a search for the largest specification that it meets: minutes.)
tools=paper-tool,endmill-16
many=2
vary=""
entries=0
for percent in 1 2 3 4 5 6 7 8; do
    for quantity in ki ks sensor_gain delay amplifier_bandwidth damping modulus; do
        [ $((many * (1 + 2 * entries))) -ge "$variants" ] && break 2
        vary="$vary${vary:+,}$quantity=$percent%"
        entries=$((entries + 1))
    done
done
muspin --quiet batch --spindle results/reference/spindle.yaml --tools "$tools" ${vary:+--vary "$vary"} --quick --no-polish --plan "$place/plan"
planned=$(wc -l < "$place/plan/commands.txt")
echo "planned: $planned variants, the array takes the first $variants"
began=$(date +%s)
job=$(cd "$place/plan" && sbatch --parsable --array=1-"$variants" slurm.sh)
finished() { ls -d "$place"/plan/results/*/row.json 2> /dev/null | wc -l; }
left() { squeue --noheader --array --job="$job" 2> /dev/null | wc -l; }

# A process with everything below it.
tree() {
    echo "$1"
    for child in $(pgrep -P "$1" || true); do tree "$child"; done
}
# The steps of slurmd on a node: their log is that of the node.
steps_of() {
    for step in $(pgrep -f "^slurmstepd: \[$job" || true); do
        if ls -l "/proc/$step/fd" 2> /dev/null | grep -q "slurmd-$1.log"; then echo "$step"; fi
    done
}

killed=""
back=""
while [ "$(left)" -gt 0 ]; do
    sleep 1
    if [ -z "$killed" ] && [ "$(finished)" -ge $((variants / 2)) ] && [ -n "$(steps_of "n$nodes")" ]; then
        # A node dies with whatever runs on it, without a word to the controller.
        killed="n$nodes"
        lost=$(squeue --noheader --array --job="$job" --nodelist="$killed" --states=RUNNING --format=%K | paste -sd' ' -)
        dead="$(cat "$place/slurmd-$killed.pid")"
        for step in $(steps_of "$killed"); do dead="$dead $(tree "$step")"; done
        # shellcheck disable=SC2086
        kill -9 $dead 2> /dev/null || true
        echo "$(finished) finished: killed $killed, on which variant ${lost:-none} was running ($(wc -w <<< "$dead") processes)"
    fi
    if [ -n "$killed" ] && [ -z "$back" ] && sinfo --noheader --nodes="$killed" --format=%t | grep -q down; then
        echo "Slurm has seen it: $(sinfo --noheader --nodes="$killed" --format='%N %t'); the node comes back"
        slurmd -N "$killed"
        back=yes
    fi
done
took=$(($(date +%s) - began))
requeued=$(grep -ci "requeue.*$job\|$job.*requeue" "$place/slurmctld.log" || true)
grep -i "requeue" "$place/slurmctld.log" | tail -3 || true
echo "took $took s: $(finished) of $variants finished, $requeued lines of requeue in the log of the controller"
muspin --quiet batch --collect "$place/plan" --out "$place/table" || [ $? -eq 1 ]
rows=$(($(wc -l < "$place/table/tools.csv") - 1))
unfinished=$(grep -c "not finished" "$place/table/tools.csv" || true)
echo "table: $rows rows, $unfinished of them not finished"
[ "$(finished)" -eq "$variants" ] && [ -n "$killed" ] && [ "$requeued" -gt 0 ] && [ "$rows" -eq "$planned" ]
