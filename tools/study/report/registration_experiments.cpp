// The experiments on registration, in the thesis's order.

#include "tools/study/report/registration_pairs.hpp"

namespace lcmslam {

std::vector<Experiment> registration_experiments() {
  const auto pairs = std::make_shared<PairStore>();
  return {overlap_experiment(pairs),     known_start_experiment(pairs), convergence_experiment(pairs),
          frustum_experiment(pairs),     estimators_experiment(pairs),  noise_overlap_experiment(pairs),
          alternation_experiment(pairs), icp_parts_experiment(pairs),   prefilter_experiment(),
          real_pairs_experiment()};
}

}  // namespace lcmslam
