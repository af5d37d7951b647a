#pragma once
// Pairs of simulated images whose relative pose is known exactly, for the experiments on registration.

#include <cmath>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include <lcmslam/registration/registration_settings.hpp>
#include "tools/study/pair_view.hpp"
#include "tools/study/report/experiment.hpp"

namespace lcmslam {

struct RegistrationPair {
  std::string scene;
  double apart = 0;  ///< s between both images
  PairView source, target;
  Eigen::Isometry3d T_target_source;  ///< exact, of the clouds
  double overlap = 0;                 ///< share of the source that the target shows
};

/// ToF head, pairs spread over the scene's path, `apart` s between their images.
struct PairChoice {
  std::string scene = "kitchen";
  int seed = 1;
  int pairs = 8;
  double apart = 1;          ///< s
  double voxel_size = 0.04;  ///< m
  double min_overlap = 0.5;  ///< of the source by the target; pairs with less are left out
};

/// Renders pairs once.
class PairStore {
 public:
  const std::vector<RegistrationPair>& pairs(const PairChoice& choice);

 private:
  std::mutex mutex_;
  std::vector<std::pair<std::string, std::unique_ptr<std::vector<RegistrationPair>>>> kept_;
};
using SharedPairs = std::shared_ptr<PairStore>;

/// A registered pair: within 5 cm and 2 degrees is right.
struct PairError {
  double translation = 0;  ///< m
  double rotation = 0;     ///< degrees
  bool right() const { return translation <= 0.05 && rotation <= 2; }
};
PairError error_of(const RegistrationPair& pair, const Eigen::Isometry3d& T_target_source);

/// Truth, moved by so much in directions that `number` draws: m and degrees.
Eigen::Isometry3d start_beside(const RegistrationPair& pair, double translation, double rotation, int number);

/// How a choice of points agrees with the true one.
struct Agreeing {
  int both = 0, chosen = 0, real = 0;
  void count(bool is_chosen, bool is_real) {
    both += is_chosen && is_real ? 1 : 0;
    chosen += is_chosen ? 1 : 0;
    real += is_real ? 1 : 0;
  }
  void add(const Agreeing& other) {
    both += other.both;
    chosen += other.chosen;
    real += other.real;
  }
  double precision() const { return chosen > 0 ? static_cast<double>(both) / chosen : std::nan(""); }
  double recall() const { return real > 0 ? static_cast<double>(both) / real : std::nan(""); }
};

/// Thesis algorithm 3.1: point to point by the estimator, all points, until the RMS error stands still.
RegistrationSettings thesis_icp(SolverKind solver);

/// Points seen from above in the target's frame (x right, z forward), at most a few hundred.
ChartSeries cloud_from_above(const std::string& name, const Cloud& cloud, const Eigen::Isometry3d& T);

Experiment overlap_experiment(const SharedPairs& pairs);
Experiment known_start_experiment(const SharedPairs& pairs);
Experiment convergence_experiment(const SharedPairs& pairs);
Experiment frustum_experiment(const SharedPairs& pairs);
Experiment estimators_experiment(const SharedPairs& pairs);
Experiment noise_overlap_experiment(const SharedPairs& pairs);
Experiment alternation_experiment(const SharedPairs& pairs);
Experiment icp_parts_experiment(const SharedPairs& pairs);
Experiment prefilter_experiment();
Experiment real_pairs_experiment();

}  // namespace lcmslam
