// The experiments on mapping, in the thesis's order.

#include "tools/study/report/mapping_parts.hpp"

namespace lcmslam {

std::vector<Experiment> mapping_experiments() {
  const auto drives = std::make_shared<DriveStore>();
  return {sampled_poses_experiment(),
          kitchen_landmarks_experiment(drives),
          table_loop_experiment(drives),
          path_noise_experiment(drives),
          dense_maps_experiment(drives),
          filter_divergence_experiment(),
          mapper_comparison_experiment(drives),
          weak_cases_experiment(drives),
          moving_people_experiment(drives),
          presets_experiment(drives),
          robustness_experiment(drives),
          consistency_experiment(drives),
          scaling_experiment(drives),
          calibration_experiment(drives),
          recordings_experiment()};
}

}  // namespace lcmslam
