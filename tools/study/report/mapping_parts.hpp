#pragma once
// The experiments on mapping, a file each. Those on the same scenes share their drives.

#include <memory>

#include "tools/study/report/drive.hpp"
#include "tools/study/report/experiment.hpp"

namespace lcmslam {

using SharedDrives = std::shared_ptr<DriveStore>;

Experiment sampled_poses_experiment();
Experiment kitchen_landmarks_experiment(const SharedDrives& drives);
Experiment table_loop_experiment(const SharedDrives& drives);
Experiment path_noise_experiment(const SharedDrives& drives);
Experiment dense_maps_experiment(const SharedDrives& drives);
Experiment filter_divergence_experiment();
Experiment mapper_comparison_experiment(const SharedDrives& drives);
Experiment weak_cases_experiment(const SharedDrives& drives);
Experiment moving_people_experiment(const SharedDrives& drives);
Experiment presets_experiment(const SharedDrives& drives);
Experiment robustness_experiment(const SharedDrives& drives);
Experiment consistency_experiment(const SharedDrives& drives);
Experiment scaling_experiment(const SharedDrives& drives);
Experiment calibration_experiment(const SharedDrives& drives);
Experiment recordings_experiment();

}  // namespace lcmslam
