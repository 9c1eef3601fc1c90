#!/bin/bash
#SBATCH --job-name=@name@
@account@#SBATCH --array=@range@
#SBATCH --cpus-per-task=@cpus@
#SBATCH --mem-per-cpu=@memory_mb@M
#SBATCH --time=@minutes@
#SBATCH --requeue
#SBATCH --open-mode=append
#SBATCH --signal=B:USR1@60
#SBATCH --output=@log@
@options@
# Every task flies its part of the batch and stores each episode as it ends. A task that starts again, because it was
# killed, its node failed or its time ran out, flies only what is missing.
fly() {
  @program@ batch @file@ --out @out@ --resume \
    --shard "${SLURM_ARRAY_TASK_ID}/@tasks@" --jobs @cpus@@memory_limit@ &
  work=$!
  wait "$work"
}
out_of_time() {
  kill -TERM "$work"; wait "$work"
  [ "${SLURM_RESTART_COUNT:-0}" -lt 20 ] && scontrol requeue "${SLURM_ARRAY_JOB_ID}_${SLURM_ARRAY_TASK_ID}"
  exit 1
}
trap out_of_time USR1
for attempt in 1 2 3; do
  fly
  status=$?
  [ "$status" -le 128 ] && break  # above: ended by a signal
done
exit "$status"
