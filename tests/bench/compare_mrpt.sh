#!/usr/bin/env bash
# FastSLAM beside MRPT's kf-slam (an EKF over robot and all landmarks, Debian's mrpt-apps) on the same scenes:
# 35, 70, 150 and 300 landmarks, about ten of them seen a step, identities known. CPU time a step once the map is
# full: of kf-slam the difference between a run of twelve laps and one of two, so that loading does not count.
#   tests/bench/compare_mrpt.sh [bench_fastslam]
set -euo pipefail
bench=$(realpath "${1:-build/release/bin/bench_fastslam}")
for program in simul-landmarks kf-slam; do
  command -v $program >/dev/null || {
    echo "compare_mrpt: $program is not installed (Debian: apt-get install mrpt-apps); MRPT is not compared" >&2
    exit 77
  }
done
[ -x "$bench" ] || { echo "compare_mrpt: no program $bench" >&2; exit 1; }
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
export LCMSLAM_MRPT_SCENES=$folder QT_QPA_PLATFORM=offscreen

simulate() { # landmarks steps
  cat >scene.ini <<END
[Params]
outFile=scene.rawlog
outDir=$1-$2
random_seed=1
nSteps=$2
circularPath=1
sensorDetectsIDs=1
odometryNoiseXY_std=0.003
odometryNoisePhi_std_deg=0.115
minSensorDistance=0
maxSensorDistance=30
fieldOfView_deg=$((3600 / $1))
stdRange=0.01
stdYaw_deg=0.1
stdPitch_deg=0.1
[RANDOMSET_1]
nLandmarks=$1
min_x=-9
max_x=9
min_y=-7
max_y=11
min_z=-0.05
max_z=0.05
END
  simul-landmarks scene.ini </dev/null >/dev/null
}

cpu_seconds() { # landmarks steps -> user time of kf-slam; "map.txt" gets its last map size
  cat >kf.ini <<END
[MappingApplication]
rawlog_file=$1-$2/scene.rawlog
logOutput_dir=log
SAVE_LOG_FREQUENCY=1000000
SHOW_3D_LIVE=false
[RangeBearingKFSLAM_KalmanFilter]
method=${KF_METHOD:-1}
verbosity_level=INFO
[RangeBearingKFSLAM]
force_ignore_odometry=false
std_sensor_range=0.01
std_sensor_yaw_deg=0.1
std_sensor_pitch_deg=0.1
END
  local TIMEFORMAT=%U
  { time kf-slam kf.ini "$1-$2/scene.rawlog" </dev/null >kf.log 2>&1; } 2>&1
  grep -o 'landmarks in the map: [0-9]*' kf.log | tail -1 | grep -o '[0-9]*$' >map.txt
}

few=148 many=868 # 4 steps of standing still and 2 or 12 laps of 72
echo "landmarks  mapped  kf-slam ms/step"
for landmarks in 35 70 150 300; do
  simulate $landmarks $few
  simulate $landmarks $many
  short=$(cpu_seconds $landmarks $few)
  long=$(cpu_seconds $landmarks $many)
  awk -v n=$landmarks -v m="$(cat map.txt)" -v a="$short" -v b="$long" -v steps=$((many - few)) \
    'BEGIN { printf "%9d  %6d  %15.3f\n", n, m, 1000 * (b - a) / steps }'
done
"$bench" --benchmark_filter=mrpt_scene --benchmark_repetitions=3 --benchmark_report_aggregates_only=true
