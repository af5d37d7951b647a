// Thesis, section 3.6: the three estimators of a rigid motion inside ICP. The thesis says that the
// small-angle method is the quickest and most robust one and that the quaternion converges where SVD fails.

#include <fmt/format.h>
#include <cmath>
#include <map>

#include <lcmslam/registration/kd_tree_target.hpp>
#include <lcmslam/registration/registration.hpp>
#include <lcmslam/runtime/machine.hpp>
#include "tools/study/report/registration_pairs.hpp"
#include "tools/study/report/result_parts.hpp"

namespace lcmslam {
namespace {

constexpr SolverKind estimators[] = {SolverKind::svd, SolverKind::svd_uncorrected, SolverKind::quaternion,
                                     SolverKind::small_angle};

struct EstimatorTally {
  int runs = 0, right = 0;
  std::vector<double> iterations, errors, seconds;
};

/// Alike scenes: with things that stand about, and bare walls with a floor.
const char* const estimator_scenes[] = {"kitchen", "corridor"};

void add_case(const RegistrationPair& pair, const KdTreeTarget& target, SolverKind solver,
              const Eigen::Isometry3d& T_start, EstimatorTally& tally) {
  const double before = thread_cpu_seconds();
  const RegistrationResult found = register_cloud(pair.source.cloud, target, T_start, thesis_icp(solver));
  tally.seconds.push_back(thread_cpu_seconds() - before);
  const PairError error = error_of(pair, found.T_target_source);
  ++tally.runs;
  tally.right += error.right() ? 1 : 0;
  tally.iterations.push_back(static_cast<double>(found.rms.size()));
  if (error.right()) tally.errors.push_back(error.translation);
}

ExperimentResult study_estimators(const StudyContext& context, PairStore& store) {
  ExperimentResult result;
  result.seeds = {context.seeds.front()};
  const std::vector<double> turns =
      context.quick ? std::vector<double>{5, 20} : std::vector<double>{0, 5, 10, 20, 30, 45};
  const int count = context.quick ? 2 : 8;
  constexpr double shift = 0.1;
  result.settings = {{"pairs_of_a_scene", count},
                     {"apart_s", 0.5},
                     {"translation_offset_m", shift},
                     {"rotation_offsets_deg", turns}};
  std::map<std::string, std::map<SolverKind, EstimatorTally>> tallies;
  std::map<std::string, Chart> charts;
  for (const char* scene : estimator_scenes) {
    charts[scene] = {std::string("Right results by rotation offset, ") + scene,
                     {"rotation offset", "deg"},
                     {"right", "%"},
                     {},
                     false};
    std::map<SolverKind, std::vector<EstimatorTally>> by_turn;
    int number = 0;
    for (const RegistrationPair& pair : store.pairs({scene, context.seeds.front(), count, 0.5, 0.04, 0.5})) {
      const KdTreeTarget target(pair.target.cloud);
      ++number;
      for (const SolverKind solver : estimators) {
        by_turn[solver].resize(turns.size());
        for (std::size_t t = 0; t < turns.size(); ++t) {
          const Eigen::Isometry3d T_start = start_beside(pair, shift, turns[t], number);
          add_case(pair, target, solver, T_start, by_turn[solver][t]);
          add_case(pair, target, solver, T_start, tallies[scene][solver]);
        }
      }
    }
    for (const SolverKind solver : estimators) {
      ChartSeries series;
      series.name = to_string(solver);
      for (std::size_t t = 0; t < turns.size(); ++t) {
        series.x.push_back(turns[t]);
        series.y.push_back(100.0 * by_turn[solver][t].right / by_turn[solver][t].runs);
      }
      charts[scene].series.push_back(series);
    }
    result.charts.push_back(charts[scene]);
  }
  ResultTable table{"All offsets",
                    {"scene", "estimator", "runs", "right", "iterations (median)", "error of right ones cm"},
                    {}};
  for (const char* scene : estimator_scenes)
    for (const SolverKind solver : estimators) {
      const EstimatorTally& t = tallies[scene][solver];
      table.rows.push_back({scene, to_string(solver), t.runs, t.right, number(spread_of(t.iterations).median),
                            number(100 * spread_of(t.errors).median)});
      result.timing[std::string(scene) + ", " + to_string(solver)] = number(spread_of(t.seconds).median);
    }
  result.tables = {table};
  const auto right = [&](SolverKind solver) {
    return tallies["kitchen"][solver].right + tallies["corridor"][solver].right;
  };
  const auto iterations = [&](SolverKind solver) {
    return spread_of(tallies["kitchen"][solver].iterations).median;
  };
  const bool robust =
      right(SolverKind::small_angle) > std::max(right(SolverKind::svd), right(SolverKind::quaternion));
  const bool quick = iterations(SolverKind::small_angle) <
                     std::min(iterations(SolverKind::svd), iterations(SolverKind::quaternion));
  const bool beyond_svd = right(SolverKind::quaternion) > right(SolverKind::svd);
  const int claims = (robust ? 1 : 0) + (quick ? 1 : 0) + (beyond_svd ? 1 : 0);
  result.agreement = claims == 3  ? Agreement::agrees
                     : claims > 0 ? Agreement::agrees_in_part
                                  : Agreement::differs;
  const int runs = tallies["kitchen"][SolverKind::svd].runs + tallies["corridor"][SolverKind::svd].runs;
  result.finding = fmt::format(
      "Right in {} (SVD), {} (SVD without the determinant's correction), {} (quaternion) and {} (small "
      "angle) of {} runs. Small "
      "angle the most robust: {}; with the fewest iterations ({:.0f} against {:.0f}): {}; the quaternion "
      "converges where SVD "
      "fails: {}.",
      right(SolverKind::svd), right(SolverKind::svd_uncorrected), right(SolverKind::quaternion),
      right(SolverKind::small_angle), runs, robust ? "holds" : "does not hold",
      iterations(SolverKind::small_angle), iterations(SolverKind::svd), quick ? "holds" : "does not hold",
      beyond_svd ? "holds" : "does not hold");
  return result;
}

}  // namespace

Experiment estimators_experiment(const SharedPairs& pairs) {
  return {"estimators", "SVD, unit quaternion and small angles", "section 3.6",
          [pairs](const StudyContext& context) { return study_estimators(context, *pairs); }};
}

}  // namespace lcmslam
