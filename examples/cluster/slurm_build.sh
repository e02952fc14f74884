#!/usr/bin/env bash
# Builds a site on a Slurm cluster whose nodes share the output folder: stages that are cut into cells run as job arrays, the
# rest runs here. Truth is what lies in the folder, never the queue: what a lost node leaves undone is asked for again.
#   examples/cluster/slurm_build.sh SITE.toml OUT [CHUNKS [SBATCH OPTION...]]
# ORTHODRIVE names the program, ORTHODRIVE_THREADS the threads of a task (1).
set -euo pipefail
if [ $# -lt 2 ]; then
  echo "usage: $0 SITE.toml OUT [CHUNKS [SBATCH OPTION...]]" >&2
  exit 2
fi
tool=${ORTHODRIVE:-orthodrive} threads=${ORTHODRIVE_THREADS:-1}
site=$(realpath "$1") out=$(realpath -m "$2") chunks=${3:-100}
shift $(($# < 3 ? $# : 3))
mkdir -p "$out"

# Until the queue has the job no more. Asks every second at first, then less often: "sbatch --wait" would see the end
# of a short job half a minute late.
wait_for() {
  local began=$SECONDS pause
  while [ -n "$(squeue --noheader --jobs="$1" 2>/dev/null)" ]; do
    pause=$(((SECONDS - began) / 20))
    sleep "$((pause < 1 ? 1 : pause > 10 ? 10 : pause))"
  done
}

rounds_without_progress=0 last=
while :; do
  # Runs all stages up to the next one that has cells to make; says which, and how many.
  next=$("$tool" --quiet --threads "$threads" cells merge "$site" -o "$out")
  [ "$next" != done ] || break
  echo "$next"
  if [ "$next" = "$last" ]; then rounds_without_progress=$((rounds_without_progress + 1)); else rounds_without_progress=0; fi
  if [ "$rounds_without_progress" -ge 5 ]; then
    echo "$0: five rounds made no cell of: $next; see $out/.orthodrive/cells/*.log" >&2
    exit 1
  fi
  last=$next
  mkdir -p "$out/.orthodrive/cells"  # for the logs: Slurm starts no task whose output it cannot open
  # A task that fails is no error here: what is missing is asked for again.
  job=$(sbatch --parsable --requeue --array=0-$((chunks - 1)) --cpus-per-task="$threads" --job-name=orthodrive \
    --output="$out/.orthodrive/cells/%A_%a.log" "$@" \
    --wrap "exec '$tool' --quiet --threads $threads cells run '$site' -o '$out' --chunk \$SLURM_ARRAY_TASK_ID --chunks $chunks")
  wait_for "${job%%;*}"
done
rm -f "$out"/.orthodrive/cells/*.log
echo "$out/report.html"
