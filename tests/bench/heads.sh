#!/usr/bin/env bash
# Errors of both mappers with each head of config/heads: the simulated kitchen, ATE (m, after an SE(3) alignment) of
# FASTSLAM_POSE, ICP_POSE while driving and ICP_FINAL, for each seed, and CPU a frame in batch.
#   tests/bench/heads.sh [-h "HEAD ..."] [-s "SEED ..."] [-r HZ] [-t SECONDS] [-o "simulate's options"]
# Rendering takes most of the time (azure_kinect: a second a frame): -r 5 or 10 thins the images.
set -euo pipefail
heads="swissranger kinect_v1 orbbec_astra realsense_d435 azure_kinect" seeds="1 2 3" rate=0 seconds=0 options=""
while getopts h:s:r:t:o: option; do
  case $option in
    h) heads=$OPTARG ;; s) seeds=$OPTARG ;; r) rate=$OPTARG ;; t) seconds=$OPTARG ;; o) options=$OPTARG ;;
    *) exit 2 ;;
  esac
done
source=$(cd "$(dirname "$0")/../.." && pwd)
lcmslam=$source/build/release/bin/lcmslam
folder=${HEADS_FOLDER:-$(mktemp -d)}
[ -n "${HEADS_FOLDER:-}" ] || trap 'rm -rf "$folder"' EXIT
mkdir -p "$folder"
printf '%-15s %4s %7s %9s %9s %9s %9s\n' head seed frames fastslam icp final 'cpu ms'
for head in $heads; do
  for seed in $seeds; do
    log=$folder/$head-$seed.lcmlog out=$folder/$head-$seed
    # shellcheck disable=SC2086  # options are words
    "$lcmslam" simulate "$source/config/scenes/kitchen.yaml" "$log" --force --head "$head" --seed "$seed" \
      --rate "$rate" --seconds "$seconds" $options >"$out.simulate" 2>&1 || { tail -3 "$out.simulate" >&2; exit 1; }
    "$lcmslam" batch "$source/config/replay.yaml" "$log" --out "$out" --force --threads 1 \
      --set fastslam.seed="$seed" >"$out.batch" 2>&1 || { tail -3 "$out.batch" >&2; exit 1; }
    "$lcmslam" evaluate "$out/batch.lcmlog" --truth "$log" >"$out.evaluate" 2>&1 || { tail -3 "$out.evaluate" >&2; exit 1; }
    ate() { awk -v name="$1" '$1 == name { print $5 }' "$out.evaluate"; }
    read -r frames cpu <<<"$(sed -nE 's/^([0-9]+) frames,.* ([0-9.]+) s CPU$/\1 \2/p' "$out.batch")"
    printf '%-15s %4s %7s %9s %9s %9s %9s\n' "$head" "$seed" "$frames" "$(ate FASTSLAM_POSE)" "$(ate ICP_POSE)" \
      "$(ate ICP_FINAL)" "$(awk -v c="$cpu" -v f="$frames" 'BEGIN { printf "%.1f", 1000 * c / f }')"
    rm -f "$log"
  done
done
