// The study's experiments on registration: that their pairs and starts are what they say, and that two of
// them find what is known of the method.

#include <gtest/gtest.h>

#include <filesystem>
#include <set>
#include <stdexcept>

#include <lcmslam/registration/kd_tree_target.hpp>
#include <lcmslam/registration/registration.hpp>
#include "tools/study/report/registration_pairs.hpp"

namespace lcmslam {
namespace {

StudyContext quick_context() {
  StudyContext context;
  context.quick = true;
  context.seeds = {4};
  context.work = std::filesystem::temp_directory_path() / "lcmslam_registration_experiments";
  std::filesystem::create_directories(context.work);
  return context;
}

const RegistrationPair& a_pair() {
  static PairStore store;
  return store.pairs({"table", 4, 1, 0.5, 0.04, 0.5}).at(0);
}

TEST(RegistrationPairs, CloudsLieOnEachOtherAtTheTruth) {
  const RegistrationPair& pair = a_pair();
  EXPECT_GT(pair.overlap, 0.5);
  const KdTreeTarget target(pair.target.cloud);
  const auto at_truth = look(pair.source.cloud, target, pair.T_target_source, thesis_icp(SolverKind::svd));
  const auto beside =
      look(pair.source.cloud, target, start_beside(pair, 0.1, 0, 1), thesis_icp(SolverKind::svd));
  EXPECT_LT(at_truth.rms.at(0), beside.rms.at(0));
}

TEST(RegistrationPairs, StartsAreAsFarOffAsTold) {
  const RegistrationPair& pair = a_pair();
  const PairError turned = error_of(pair, start_beside(pair, 0, 12, 3));
  EXPECT_NEAR(turned.rotation, 12, 1e-6);
  const PairError moved = error_of(pair, start_beside(pair, 0.3, 0, 3));
  EXPECT_NEAR(moved.translation, 0.3, 1e-9);
  EXPECT_NEAR(moved.rotation, 0, 1e-6);
  EXPECT_FALSE(moved.right());
  EXPECT_TRUE(error_of(pair, pair.T_target_source).right());
}

TEST(RegistrationExperiments, HaveNamesOfTheirOwnAmongAll) {
  std::set<std::string> names;
  for (const auto& list : {mapping_experiments(), registration_experiments()})
    for (const Experiment& experiment : list)
      EXPECT_TRUE(names.insert(experiment.name).second) << experiment.name;
}

// From the truth itself every method stays there; from 0.3 m and 20 degrees off fewer come back.
TEST(RegistrationExperiments, ConvergenceGetsWorseWithTheOffset) {
  const auto pairs = std::make_shared<PairStore>();
  const ExperimentResult result = convergence_experiment(pairs).run(quick_context());
  ASSERT_EQ(result.heat_maps.size(), 3U);
  for (const HeatMap& map : result.heat_maps)
    EXPECT_GE(map.values.front().front(), map.values.back().back()) << map.title;
  EXPECT_GT(result.heat_maps.front().values.front().front(), 0);
  EXPECT_EQ(result.finding, convergence_experiment(pairs).run(quick_context()).finding);
}

}  // namespace
}  // namespace lcmslam
