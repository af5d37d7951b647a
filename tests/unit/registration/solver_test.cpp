#include <lcmslam/registration/solver.hpp>

#include <gtest/gtest.h>

#include "tests/unit/registration/random_pair.hpp"

namespace lcmslam {
namespace {

class ClosedForm : public testing::TestWithParam<SolverKind> {
 protected:
  static std::unique_ptr<Solver> solver() {
    RegistrationSettings settings;
    settings.metric = MetricKind::point_to_point;
    settings.solver = GetParam();
    return make_solver(settings, nullptr);
  }
  /// Pairs of points that T_true brings together, seen from T.
  static std::vector<Pair> pairs_of(const Eigen::Isometry3d& T_true, const Eigen::Isometry3d& T,
                                    Random& random) {
    std::vector<Pair> pairs;
    for (int i = 0; i < 50; ++i) {
      pairs.push_back(random_pair(random, T));
      pairs.back().target = T_true * pairs.back().source;
    }
    return pairs;
  }
};
INSTANTIATE_TEST_SUITE_P(Solvers, ClosedForm, testing::Values(SolverKind::svd, SolverKind::quaternion));

TEST_P(ClosedForm, FindsExactPairsInOneStepFromAnywhere) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Random random(seed);
    const Eigen::Isometry3d T_true = random_transform(random), T = random_transform(random);
    const auto found = solver()->solve(pairs_of(T_true, T, random), T);
    ASSERT_TRUE(found) << seed;
    EXPECT_TRUE(found->isApprox(T_true, 1e-9)) << seed;
  }
}

TEST_P(ClosedForm, PairsCountByTheirWeights) {
  Random random(5);
  const Eigen::Isometry3d T_true = random_transform(random), T = random_transform(random);
  std::vector<Pair> pairs = pairs_of(T_true, T, random);
  for (std::size_t i = 0; i < pairs.size(); i += 2) {  // half of them are wrong and count for nothing
    pairs[i].target += Eigen::Vector3d(1, 2, 3);
    pairs[i].weight = 1e-12;
  }
  EXPECT_TRUE(solver()->solve(pairs, T)->isApprox(T_true, 1e-6));
}

}  // namespace
}  // namespace lcmslam
