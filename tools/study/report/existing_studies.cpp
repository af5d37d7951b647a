// Studies that stand on their own too (lcmslam study --only depth-filter, pairs), told in the report.

#include <fmt/format.h>
#include <cmath>
#include <map>

#include <lcmslam/configuration/share.hpp>
#include "procs/camera/camera_source.hpp"
#include "tools/study/depth_filter_study.hpp"
#include "tools/study/pair_study.hpp"
#include "tools/study/report/registration_pairs.hpp"
#include "tools/study/report/result_parts.hpp"

namespace lcmslam {
namespace {

ExperimentResult study_prefilter(const StudyContext& context) {
  DepthFilterStudySettings settings;
  settings.seed = static_cast<std::uint64_t>(context.seeds.front());
  settings.heads = {"tof"};
  settings.sizes = {{176, 144}};
  settings.images = context.quick ? 2 : 8;
  for (const char* scene : {"kitchen", "table", "office"}) {
    settings.scenes.push_back(share_path(std::string("config/scenes/") + scene + ".yaml"));
    if (context.quick) break;
  }
  const DepthFilterStudyResult found = study_depth_filter(depth_filter_methods(), settings);
  ExperimentResult result;
  result.seeds = {context.seeds.front()};
  result.settings = {{"head", "tof"}, {"images_of_a_scene", settings.images}};
  ResultTable table{"Mixed pixels removed and good points lost",
                    {"scene", "method", "mixed removed %", "good lost %", "left gap, tolerances"},
                    {}};
  double removed = 1, lost = 0;
  for (const DepthFilterScore& s : found.scores) {
    table.rows.push_back({std::filesystem::path(s.scene).stem().string(), s.method,
                          number(100 * s.removed_share()), number(100 * s.lost_share()), number(s.left_gap)});
    if (s.method != found.scores.front().method) continue;
    if (std::isfinite(s.removed_share())) removed = std::min(removed, s.removed_share());
    lost = std::max(lost, s.lost_share());
  }
  Chart chart{"Removed against lost by the filter's sharpness",
              {"good points lost, worst case", "%"},
              {"mixed pixels removed, worst case", "%"},
              {},
              false};
  ChartSeries series;
  series.name = "noise_sigmas from 3 to 0.8";
  for (auto p = found.curve.rbegin(); p != found.curve.rend(); ++p) {
    series.x.push_back(100 * p->lost_share);
    series.y.push_back(100 * p->removed_share);
  }
  chart.series = {series};
  result.charts = {chart};
  result.tables = {table};
  result.finding = fmt::format(
      "The prefilter ({}) removes at least {:.0f} % of the mixed pixels and loses at most {:.1f} % of the "
      "good points; without it all of them stay.",
      found.scores.front().method, 100 * removed, 100 * lost);
  return result;
}

ExperimentResult study_real_pairs(const StudyContext& context) {
  ExperimentResult result;
  result.settings = {{"right_within", "5 cm and 2 degrees"}};
  ResultTable table{"Pairs of images whose relative pose nobody told",
                    {"recording", "frames apart", "method", "pairs", "right %"},
                    {}};
  double plain = 0, modern = 0;
  int cases = 0;
  Chart chart{"Right pairs, all recordings", {"method", ""}, {"right", "%"}, {}, false};
  std::map<int, std::map<std::string, std::pair<int, int>>> right;  // by frames apart and method: of how many
  for (const char* name : {"tum_fr1_rpy", "livingroom1"}) {
    if (context.data.empty() || !std::filesystem::is_directory(context.data / name)) continue;
    PairStudySettings settings;
    settings.apart = {10, 20};
    settings.starts = context.quick ? 2 : 15;
    DatasetSourceSettings recording;
    recording.folder = (context.data / name).string();
    const auto source = make_dataset_source(recording);
    for (const PairScore& s : study_pairs(*source, pair_methods(), settings).scores) {
      const double share = s.pairs > 0 ? 100.0 * s.right / s.pairs : std::nan("");
      table.rows.push_back({name, s.apart, s.method, s.pairs, number(share)});
      if (!std::isfinite(share)) continue;
      auto& [good, all] = right[s.apart][s.method];
      good += s.right;
      all += s.pairs;
      if (s.method == "plain ICP (3.1)") plain += share, ++cases;
      if (s.method == "modern start") modern += share;
    }
  }
  if (cases == 0) {
    result.finding = "No recording was there (--data); nothing was measured.";
    return result;
  }
  for (const auto& [apart, by_method] : right) {
    ChartSeries bars;
    bars.name = fmt::format("{} frames apart", apart);
    bars.mark = ChartSeries::Mark::bars;
    chart.x.names.clear();
    for (const auto& [method, counts] : by_method) {
      chart.x.names.push_back(method);
      bars.x.push_back(static_cast<double>(chart.x.names.size()));
      bars.y.push_back(100.0 * counts.first / counts.second);
    }
    chart.series.push_back(bars);
  }
  result.charts = {chart};
  result.tables = {table};
  result.finding = fmt::format(
      "On real recordings plain ICP is right in {:.0f} % of the pairs, the mapper's own start in {:.0f} %.",
      plain / cases, modern / cases);
  return result;
}

}  // namespace

Experiment prefilter_experiment() {
  return {"prefilter", "Mixed pixels of the ToF camera", "future work", study_prefilter};
}

Experiment real_pairs_experiment() {
  return {"real-pairs", "Pairs of real recordings", "", study_real_pairs};
}

}  // namespace lcmslam
