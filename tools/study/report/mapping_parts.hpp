#pragma once
// The experiments on mapping, a file each. Those on the same scenes share their drives.

#include <memory>

#include "tools/study/report/drive.hpp"
#include "tools/study/report/experiment.hpp"

namespace lcmslam {

using SharedDrives = std::shared_ptr<DriveStore>;

Experiment sampled_poses_experiment();
Experiment kitchen_landmarks_experiment(SharedDrives drives);
Experiment table_loop_experiment(SharedDrives drives);
Experiment path_noise_experiment(SharedDrives drives);
Experiment dense_maps_experiment(SharedDrives drives);
Experiment filter_divergence_experiment();
Experiment mapper_comparison_experiment(SharedDrives drives);
Experiment weak_cases_experiment(SharedDrives drives);
Experiment moving_people_experiment(SharedDrives drives);
Experiment presets_experiment(SharedDrives drives);
Experiment robustness_experiment(SharedDrives drives);
Experiment consistency_experiment(SharedDrives drives);
Experiment scaling_experiment(SharedDrives drives);
Experiment calibration_experiment(SharedDrives drives);
Experiment recordings_experiment();

}  // namespace lcmslam
