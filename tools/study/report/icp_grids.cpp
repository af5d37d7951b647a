// ICP over what it meets and how it is put together: range noise and overlap (thesis, section 3.2), the ratio
// of the alternation and subsampling (section 3.4.1.1), and its parts after Rusinkiewicz and Levoy (2001).

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <functional>

#include <lcmslam/dense_mapper/thesis/alternating.hpp>
#include <lcmslam/geometry/random.hpp>
#include <lcmslam/registration/kd_tree_target.hpp>
#include <lcmslam/registration/preparation.hpp>
#include <lcmslam/rgbd/colour_overlap.hpp>
#include "tools/study/report/judgements.hpp"
#include "tools/study/report/registration_pairs.hpp"
#include "tools/study/report/result_parts.hpp"

namespace lcmslam {
namespace {

/// Each point moved along its ray.
Cloud with_range_noise(Cloud cloud, double sigma, int seed) {
  Random random(static_cast<std::uint64_t>(seed), 0x4a11);
  for (Eigen::Vector3f& p : cloud.points) p += p.normalized() * static_cast<float>(random.normal(0, sigma));
  return cloud;
}

/// Pairs that overlap alike.
struct PairGroup {
  std::vector<const RegistrationPair*> pairs;
  double overlap = 0;  // median
};

/// As many groups as times between both images, of as many pairs each, by how much they overlap.
std::vector<PairGroup> by_overlap(PairStore& store, int seed, int count, const std::vector<double>& aparts) {
  std::vector<const RegistrationPair*> all;
  for (const double apart : aparts)
    for (const RegistrationPair& pair : store.pairs({"kitchen", seed, count, apart, 0.04, 0.1}))
      all.push_back(&pair);
  std::stable_sort(all.begin(), all.end(),
                   [](const auto* a, const auto* b) { return a->overlap < b->overlap; });
  std::vector<PairGroup> groups(aparts.size());
  for (std::size_t i = 0; i < all.size(); ++i) groups[i * groups.size() / all.size()].pairs.push_back(all[i]);
  for (PairGroup& group : groups) {
    std::vector<double> overlaps;
    for (const RegistrationPair* pair : group.pairs) overlaps.push_back(pair->overlap);
    group.overlap = spread_of(overlaps).median;
  }
  return groups;
}

ExperimentResult study_noise_overlap(const StudyContext& context, PairStore& store) {
  ExperimentResult result;
  result.seeds = {context.seeds.front()};
  const std::vector<double> sigmas =
      context.quick ? std::vector<double>{0, 0.04} : std::vector<double>{0, 0.01, 0.02, 0.04, 0.08};
  const std::vector<double> aparts =
      context.quick ? std::vector<double>{0.5, 3} : std::vector<double>{0.5, 1, 2, 3, 5};
  const int count = context.quick ? 3 : 10;  // for each time between both images
  result.settings = {{"scene", "kitchen"},
                     {"pairs", count},
                     {"apart_s", aparts},
                     {"start", "10 cm and 5 degrees beside the truth"}};
  const std::vector<PairGroup> groups = by_overlap(store, context.seeds.front(), count, aparts);
  HeatMap right{
      "Right results", {"overlap of both views", "%"}, {"range noise", "cm"}, {"right", "%"}, {}, {}, {}};
  HeatMap steps = right, errors = right;
  steps.title = "Iterations", steps.value = {"iterations (median)", ""};
  errors.title = "Pose error", errors.value = {"error (median)", "cm"};
  for (HeatMap* map : {&right, &steps, &errors}) {
    for (const double sigma : sigmas) map->rows.push_back(100 * sigma);
    map->values.assign(sigmas.size(), std::vector<double>(groups.size(), 0));
    for (const PairGroup& group : groups) map->columns.push_back(std::round(100 * group.overlap));
  }
  for (std::size_t a = 0; a < groups.size(); ++a) {
    for (std::size_t s = 0; s < sigmas.size(); ++s) {
      std::vector<double> iterations, translations;
      int good = 0, number = 0;
      for (const RegistrationPair* shown : groups[a].pairs) {
        const RegistrationPair& pair = *shown;
        ++number;
        const KdTreeTarget target(with_range_noise(pair.target.cloud, sigmas[s], 2 * number));
        const RegistrationResult found =
            register_cloud(with_range_noise(pair.source.cloud, sigmas[s], 2 * number + 1), target,
                           start_beside(pair, 0.1, 5, number), thesis_icp(SolverKind::svd));
        const PairError error = error_of(pair, found.T_target_source);
        good += error.right() ? 1 : 0;
        iterations.push_back(static_cast<double>(found.rms.size()));
        translations.push_back(error.translation);
      }
      right.values[s][a] = 100.0 * good / number;
      steps.values[s][a] = spread_of(iterations).median;
      errors.values[s][a] = 100 * spread_of(translations).median;
    }
    context.progress(static_cast<double>(a + 1) / static_cast<double>(groups.size()));
  }
  result.heat_maps = {right, steps, errors};
  const double sharp_much = right.values.front().back(), sharp_little = right.values.front().front(),
               noisy_much = right.values.back().back();
  result.agreement = sharp_little < sharp_much ? Agreement::agrees : Agreement::differs;
  result.finding = fmt::format(
      "Without noise plain ICP is right in {:.0f} % of the pairs that overlap by {:.0f} % and in {:.0f} % of "
      "those that overlap by {:.0f} %; with {:.0f} cm of range noise in {:.0f} % of the latter: little "
      "overlap costs {} such noise.",
      sharp_little, right.columns.front(), sharp_much, right.columns.back(), 100 * sigmas.back(), noisy_much,
      sharp_little < noisy_much    ? "more than"
      : sharp_little == noisy_much ? "as much as"
                                   : "less than");
  return result;
}

ExperimentResult study_alternation(const StudyContext& context, PairStore& store) {
  ExperimentResult result;
  result.seeds = {context.seeds.front()};
  const std::vector<std::pair<int, int>> ratios = {{1, 0}, {5, 1}, {1, 1}, {1, 5}, {0, 1}};
  const std::vector<double> voxels =
      context.quick ? std::vector<double>{0.04} : std::vector<double>{0.02, 0.04, 0.08, 0.16};
  const int count = context.quick ? 3 : 10;
  result.settings = {{"scene", "kitchen"}, {"pairs", count}, {"apart_s", 1}, {"voxels_m", voxels}};
  ResultTable table{"From SURF's initial alignment of all matches",
                    {"cloud : SURF iterations", "voxel cm", "pairs", "right", "rounds (median)",
                     "rounds whose error rises %", "error cm (median)"},
                    {}};
  Chart chart{"Right results by ratio", {"voxel", "cm"}, {"right", "%"}, {}, false};
  std::vector<AlternationRatio> judged;
  std::size_t judged_pairs = 0;
  for (const auto& [cloud, surf] : ratios) {
    ChartSeries series;
    series.name = fmt::format("{}:{}", cloud, surf);
    for (const double voxel : voxels) {
      std::vector<double> rounds, rising, translations;
      int good = 0;
      const auto& pairs = store.pairs({"kitchen", context.seeds.front(), count, 1, voxel, 0.5});
      for (const RegistrationPair& pair : pairs) {
        AlternatingSettings settings;
        settings.registration.solver = SolverKind::svd;
        settings.cloud_iterations = cloud;
        settings.feature_iterations = surf;
        const Cloud sub = overlapping_points(
            pair.source.cloud, colour_overlap(pair.source.colour, pair.target.colour), pair.source.camera);
        const FeaturePairs features = feature_pairs(pair.source.features, pair.target.features, false);
        const auto T_start =
            align_start(features, settings.registration).value_or(Eigen::Isometry3d::Identity());
        const AlternatingResult found =
            register_alternating(sub, KdTreeTarget(pair.target.cloud), features, T_start, settings);
        const PairError error = error_of(pair, found.T_target_source);
        good += error.right() ? 1 : 0;
        rounds.push_back(static_cast<double>(found.cloud_rms.size()));
        translations.push_back(error.translation);
        int up = 0;
        for (std::size_t i = 1; i < found.cloud_rms.size(); ++i)
          up += found.cloud_rms[i] > found.cloud_rms[i - 1] + 1e-6 ? 1 : 0;
        rising.push_back(rounds.back() > 1 ? up / (rounds.back() - 1) : 0);
      }
      table.rows.push_back({series.name, number(100 * voxel), pairs.size(), good,
                            number(spread_of(rounds).median), number(100 * spread_of(rising).median),
                            number(100 * spread_of(translations).median)});
      series.x.push_back(100 * voxel);
      series.y.push_back(100.0 * good / static_cast<double>(pairs.size()));
      if (voxel != 0.04) continue;
      judged.push_back({cloud, surf, static_cast<std::size_t>(good), spread_of(rising).median});
      judged_pairs = pairs.size();
    }
    chart.series.push_back(series);
  }
  if (voxels.size() > 1) result.charts = {chart};
  result.tables = {table};
  Judgement judgement = judge_alternation(judged, judged_pairs);
  result.agreement = judgement.agreement;
  result.finding = std::move(judgement.finding);
  return result;
}

struct Variant {
  std::string part, name;
  std::function<void(RegistrationSettings&)> change;
};

const std::vector<Variant>& variants() {
  static const std::vector<Variant> all = {
      {"base", "point to plane, all points", [](auto&) {}},
      {"selection", "uniform", [](auto& s) { s.selection = SelectionKind::uniform; }},
      {"selection", "random", [](auto& s) { s.selection = SelectionKind::random; }},
      {"selection", "normal space", [](auto& s) { s.selection = SelectionKind::normal_space; }},
      {"selection", "stable", [](auto& s) { s.selection = SelectionKind::stable; }},
      {"matching", "mutual nearest", [](auto& s) { s.mutual = true; }},
      {"weighting", "all alike", [](auto& s) { s.weigh_by_noise = false; }},
      {"weighting", "no robust kernel", [](auto& s) { s.kernel = KernelKind::none; }},
      {"weighting", "Huber", [](auto& s) { s.kernel = KernelKind::huber; }},
      {"rejection", "no distance rule", [](auto& s) { s.distance_sigmas = 0; }},
      {"rejection", "any normals", [](auto& s) { s.max_normal_angle = 3.2; }},
      {"rejection", "trimmed to 70 %", [](auto& s) { s.trimmed_fraction = 0.7; }},
      {"rejection", "no rim", [](auto& s) { s.boundary = true; }},
      {"metric", "point to point", [](auto& s) { s.metric = MetricKind::point_to_point; }},
      {"metric", "plane to plane", [](auto& s) { s.metric = MetricKind::plane_to_plane; }}};
  return all;
}

ExperimentResult study_parts(const StudyContext& context, PairStore& store) {
  ExperimentResult result;
  result.seeds = {context.seeds.front()};
  const int count = context.quick ? 2 : 10;
  result.settings = {{"scene", "kitchen"},
                     {"pairs", count},
                     {"apart_s", 1},
                     {"start", "15 cm and 8 degrees beside the truth"},
                     {"selected_points", 1000}};
  ResultTable table{"One part changed at a time",
                    {"part", "variant", "pairs", "right", "iterations (median)", "error cm (median)"},
                    {}};
  Chart chart{"Pose error by variant", {"variant", ""}, {"error (median)", "cm"}, {}, false};
  double base = 0, best = std::numeric_limits<double>::infinity(), worst = 0;
  std::string best_name, worst_name;
  ChartSeries bars;
  bars.name = "error";
  bars.mark = ChartSeries::Mark::bars;
  for (const Variant& variant : variants()) {
    RegistrationSettings settings;
    settings.selected_points = 1000;
    settings.max_iterations = 60;
    variant.change(settings);
    std::vector<double> iterations, translations;
    int good = 0, number_of = 0;
    for (const RegistrationPair& pair :
         store.pairs({"kitchen", context.seeds.front(), count, 1, 0.04, 0.5})) {
      const RegistrationResult found = register_clouds(pair.source.cloud, pair.target.cloud,
                                                       start_beside(pair, 0.15, 8, ++number_of), {settings});
      const PairError error = error_of(pair, found.T_target_source);
      good += error.right() ? 1 : 0;
      iterations.push_back(static_cast<double>(found.rms.size()));
      translations.push_back(error.translation);
    }
    const double median_error = spread_of(translations).median;
    table.rows.push_back({variant.part, variant.name, number_of, good, number(spread_of(iterations).median),
                          number(100 * median_error)});
    bars.x.push_back(static_cast<double>(bars.x.size() + 1));
    chart.x.names.push_back(variant.name);
    bars.y.push_back(100 * median_error);
    if (variant.part == "base") base = median_error;
    if (median_error < best) best = median_error, best_name = variant.name;
    if (median_error > worst) worst = median_error, worst_name = variant.name;
  }
  chart.series = {bars};
  result.charts = {chart};
  result.tables = {table};
  result.finding = fmt::format(
      "Of one part changed at a time, {} does best ({:.1f} cm), {} worst ({:.1f} cm); the base has {:.1f} "
      "cm.",
      best_name, 100 * best, worst_name, 100 * worst, 100 * base);
  return result;
}

}  // namespace

Experiment noise_overlap_experiment(const SharedPairs& pairs) {
  return {"noise-overlap", "ICP over range noise and overlap", "section 3.2",
          [pairs](const StudyContext& context) { return study_noise_overlap(context, *pairs); }};
}

Experiment alternation_experiment(const SharedPairs& pairs) {
  return {"alternation", "Turns between cloud and SURF points", "section 3.4.1.1",
          [pairs](const StudyContext& context) { return study_alternation(context, *pairs); }};
}

Experiment icp_parts_experiment(const SharedPairs& pairs) {
  return {"icp-parts", "ICP's parts, one changed at a time", "",
          [pairs](const StudyContext& context) { return study_parts(context, *pairs); }};
}

}  // namespace lcmslam
