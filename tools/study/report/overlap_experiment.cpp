// Thesis, figures 3.2 to 3.4: which points of one view the other shows, by colour (NCC) and by SURF
// correspondences; held against what the scene's exact poses say.

#include <fmt/format.h>
#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include <lcmslam/dense_mapper/thesis/alternating.hpp>
#include <lcmslam/registration/kd_tree_target.hpp>
#include <lcmslam/rgbd/colour_overlap.hpp>
#include "tools/study/report/registration_pairs.hpp"
#include "tools/study/report/result_parts.hpp"

namespace lcmslam {
namespace {

/// Points of the source that have a surface of the target where they truly lie.
std::vector<bool> truly_shared(const RegistrationPair& pair, const KdTreeTarget& target) {
  constexpr float reach = 0.08f;
  std::vector<bool> shared;
  TargetPoint found;
  const Eigen::Isometry3f T = pair.T_target_source.cast<float>();
  for (const Eigen::Vector3f& p : pair.source.cloud.points)
    shared.push_back(target.find(T * p, reach, found));
  return shared;
}

Picture mask_picture(const StudyContext& context, const RegistrationPair& pair, const ImageOverlap& overlap) {
  cv::Mat image = pair.source.colour.clone();
  for (const Segment& segment : overlap.segments()) {
    const bool out = segment.state == SegmentState::outside;
    if (out) image(segment.area) *= 0.35;
    cv::rectangle(image, segment.area, out ? cv::Scalar(60, 60, 60) : cv::Scalar(115, 158, 0), 1);
    if (segment.state == SegmentState::unknown)
      cv::putText(image, "?", (segment.area.tl() + segment.area.br()) / 2, cv::FONT_HERSHEY_SIMPLEX, 0.6,
                  cv::Scalar(66, 228, 240), 2);
  }
  cv::Mat both;
  cv::hconcat(image, pair.target.colour, both);
  const std::filesystem::path file = context.work / "overlap.png";
  cv::imwrite(file.string(), both);
  return {"Source with its overlapping segments, and the target",
          "Left the source image: segments that the right image does not show are dark, question marks are "
          "too plain to "
          "tell. Right the target image.",
          file};
}

ExperimentResult study_overlap(const StudyContext& context, PairStore& store) {
  ExperimentResult result;
  result.seeds = {context.seeds.front()};
  const std::vector<double> aparts =
      context.quick ? std::vector<double>{1, 3} : std::vector<double>{0.5, 1, 2, 3, 5};
  const int count = context.quick ? 3 : 8;
  result.settings = {{"scene", "kitchen"}, {"pairs", count}, {"apart_s", aparts}};
  Chart chart{"Overlap mask by NCC, and SURF correspondences",
              {"between both images", "s"},
              {"share", "%"},
              {},
              false};
  std::vector<std::vector<double>> precision(aparts.size()), recall(aparts.size()), right(aparts.size());
  ResultTable table{"Medians over pairs",
                    {"apart s", "true overlap %", "NCC precision %", "NCC recall %", "SURF correspondences",
                     "of them right %"},
                    {}};
  for (std::size_t a = 0; a < aparts.size(); ++a) {
    std::vector<double> overlaps, matches;
    for (const RegistrationPair& pair :
         store.pairs({"kitchen", context.seeds.front(), count, aparts[a], 0.04, 0.1})) {
      const KdTreeTarget target(pair.target.cloud);
      const ImageOverlap overlap = colour_overlap(pair.source.colour, pair.target.colour);
      const std::vector<bool> shared = truly_shared(pair, target);
      Agreeing agreeing;
      for (std::size_t i = 0; i < shared.size(); ++i)
        agreeing.count(may_overlap(pair.source.cloud.points[i].cast<double>(), overlap, pair.source.camera),
                       shared[i]);
      precision[a].push_back(agreeing.precision());
      recall[a].push_back(agreeing.recall());
      const FeaturePairs features = feature_pairs(pair.source.features, pair.target.features, false);
      int good = 0;
      for (std::size_t i = 0; i < features.source.size(); ++i)
        good += (pair.T_target_source.cast<float>() * features.source[i] - features.target[i]).norm() < 0.1f
                    ? 1
                    : 0;
      const auto n = static_cast<double>(features.source.size());
      matches.push_back(n);
      right[a].push_back(n > 0 ? good / n : std::nan(""));
      overlaps.push_back(pair.overlap);
      if (a != 1 || !result.pictures.empty()) continue;
      result.pictures.push_back(mask_picture(context, pair, overlap));
      Chart before{"Both clouds from above, before", {"right", "m"}, {"forward", "m"}, {}, true},
          after = before;
      after.title = "The same with SURF's initial alignment";
      const auto T = align_start(feature_pairs(pair.source.features, pair.target.features, true),
                                 thesis_icp(SolverKind::svd));
      for (Chart* c : {&before, &after})
        c->series.push_back(cloud_from_above("target", pair.target.cloud, Eigen::Isometry3d::Identity()));
      before.series.push_back(cloud_from_above("source", pair.source.cloud, Eigen::Isometry3d::Identity()));
      after.series.push_back(
          cloud_from_above("source", pair.source.cloud, T.value_or(Eigen::Isometry3d::Identity())));
      result.charts.push_back(before);
      result.charts.push_back(after);
    }
    table.rows.push_back({aparts[a], number(100 * spread_of(overlaps).median),
                          number(100 * spread_of(precision[a]).median),
                          number(100 * spread_of(recall[a]).median), number(spread_of(matches).median),
                          number(100 * spread_of(right[a]).median)});
  }
  chart.series = {spread_series("NCC precision", aparts, precision, 100),
                  spread_series("NCC recall", aparts, recall, 100),
                  spread_series("SURF correspondences that are right", aparts, right, 100)};
  result.charts.insert(result.charts.begin(), chart);
  result.tables = {table};
  const double p = spread_of(precision[1]).median, r = spread_of(recall[1]).median,
               s = spread_of(right[1]).median;
  result.agreement = p > 0.8 && s > 0.5   ? Agreement::agrees
                     : p > 0.8 || s > 0.5 ? Agreement::agrees_in_part
                                          : Agreement::differs;
  result.finding = fmt::format(
      "Images {:.0f} s apart: of the points that NCC keeps {:.0f} % are in both views and {:.0f} % of those "
      "in both are kept; "
      "{:.0f} % of the SURF correspondences are right before anything checks them.",
      aparts[1], 100 * p, 100 * r, 100 * s);
  return result;
}

}  // namespace

Experiment overlap_experiment(const SharedPairs& pairs) {
  return {"overlap", "Which part of two views overlaps", "figures 3.2 to 3.4",
          [pairs](const StudyContext& context) { return study_overlap(context, *pairs); }};
}

}  // namespace lcmslam
