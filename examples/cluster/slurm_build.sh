#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Builds a site on a Slurm cluster whose nodes share the output folder: an array of jobs, all of which work on the build until
# it is complete. Truth is what lies in the folder, never the queue: while a stage is missing, they are started again.
#   examples/cluster/slurm_build.sh SITE.toml OUT [JOBS [SBATCH OPTION...]]
# ORTHODRIVE names the program, ORTHODRIVE_THREADS the threads of a job (1).
set -euo pipefail
if [ $# -lt 2 ]; then
  echo "usage: $0 SITE.toml OUT [JOBS [SBATCH OPTION...]]" >&2
  exit 2
fi
tool=${ORTHODRIVE:-orthodrive} threads=${ORTHODRIVE_THREADS:-1}
site=$(realpath "$1") out=$(realpath -m "$2") jobs=${3:-10}
shift $(($# < 3 ? $# : 3))
logs=$out/.orthodrive/slurm
mkdir -p "$logs" # Slurm starts no job whose output it cannot open

# Until the queue has the job no more. Asks every second at first, then less often: "sbatch --wait" would see the end
# of a short job half a minute late.
wait_for() {
  local began=$SECONDS pause
  while [ -n "$(squeue --noheader --jobs="$1" 2>/dev/null)" ]; do
    pause=$(((SECONDS - began) / 60))
    sleep "$((pause < 1 ? 1 : pause > 10 ? 10 : pause))"
  done
}

for round in 1 2 3 4 5; do
  # A job that fails is no error here: what is missing is asked for.
  job=$(sbatch --parsable --requeue --array=0-$((jobs - 1)) --cpus-per-task="$threads" --job-name=orthodrive \
    --output="$logs/%A_%a.log" "$@" \
    --wrap "exec '$tool' --quiet --threads $threads cells work '$site' -o '$out' --index \$SLURM_ARRAY_TASK_ID --of $jobs")
  wait_for "${job%%;*}"
  if missing=$("$tool" --quiet cells missing "$site" -o "$out"); then
    rm -rf "$logs"
    echo "$out/report.html"
    exit 0
  fi
  echo "round $round left: $missing"
done
echo "$0: five rounds did not complete the build; see $logs" >&2
exit 1
