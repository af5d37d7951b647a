// Thesis, figure 3.16: what of a view lies outside the frustum of the other's depth camera, held against the
// scene's exact poses, and what leaving it out does to ICP.

#include <fmt/format.h>

#include <lcmslam/registration/kd_tree_target.hpp>
#include <lcmslam/registration/registration.hpp>
#include <lcmslam/registration/view_frustum.hpp>
#include "tools/study/report/registration_pairs.hpp"
#include "tools/study/report/result_parts.hpp"

namespace lcmslam {
namespace {

/// Truth by the image alone: the point projects into the target's depth image.
bool is_in_view(const RegistrationPair& pair, const Eigen::Vector3f& point) {
  const auto pixel = pair.target.depth_camera.project(pair.target.T_camera_depth.inverse() *
                                                      pair.T_target_source * point.cast<double>());
  return pixel && pair.target.depth_camera.contains(*pixel);
}

/// A pair with and without what the target's frustum leaves out of the source.
struct CulledPair {
  Eigen::Isometry3d T_start;
  Cloud inside, outside;
  Agreeing agreeing;
  PairError all, culled;
};

CulledPair cull(const RegistrationPair& pair, int number) {
  CulledPair result;
  result.T_start = start_beside(pair, 0.1, 5, number);
  const ViewFrustum frustum(pair.target.depth_camera);
  const Eigen::Isometry3d T_depth_start = pair.target.T_camera_depth.inverse() * result.T_start;
  for (const Eigen::Vector3f& point : pair.source.cloud.points) {
    const bool kept = frustum.contains(T_depth_start.cast<float>() * point);
    (kept ? result.inside : result.outside).points.push_back(point);
    result.agreeing.count(kept, is_in_view(pair, point));
  }
  const KdTreeTarget target(pair.target.cloud);
  const auto register_these = [&](const Cloud& cloud) {
    const RegistrationSettings settings = thesis_icp(SolverKind::small_angle);
    return error_of(pair, register_cloud(cloud, target, result.T_start, settings).T_target_source);
  };
  result.all = register_these(pair.source.cloud);
  result.culled = register_these(points_inside(pair.source.cloud, frustum, T_depth_start));
  return result;
}

/// Of several pairs.
struct Tally {
  Agreeing agreeing;
  std::size_t outside = 0, points = 0;
  std::vector<double> all, culled;  // m
  int right_all = 0, right_culled = 0;

  void add(const CulledPair& pair) {
    agreeing.add(pair.agreeing);
    outside += pair.outside.size();
    points += pair.outside.size() + pair.inside.size();
    all.push_back(pair.all.translation);
    culled.push_back(pair.culled.translation);
    right_all += pair.all.right() ? 1 : 0;
    right_culled += pair.culled.right() ? 1 : 0;
  }
  double outside_share() const {
    return static_cast<double>(outside) / static_cast<double>(std::max<std::size_t>(1, points));
  }
  double median_all() const { return spread_of(all).median; }
  double median_culled() const { return spread_of(culled).median; }
};

Chart three_sets(const RegistrationPair& pair, const CulledPair& culled) {
  Chart chart{"The three sets of points from above", {"right", "m"}, {"forward", "m"}, {}, true};
  chart.series = {cloud_from_above("target", pair.target.cloud, Eigen::Isometry3d::Identity()),
                  cloud_from_above("source, inside the target's frustum", culled.inside, culled.T_start),
                  cloud_from_above("source, outside", culled.outside, culled.T_start)};
  return chart;
}

ExperimentResult study_frustum(const StudyContext& context, PairStore& store) {
  constexpr double least_overlap = 0.3;
  ExperimentResult result;
  result.seeds = {context.seeds.front()};
  const int count = context.quick ? 3 : 12;
  const std::vector<double> aparts = context.quick ? std::vector<double>{2} : std::vector<double>{1, 2, 4};
  result.settings = {{"scene", "office"},
                     {"pairs", count},
                     {"apart_s", aparts},
                     {"least_overlap", least_overlap},
                     {"start", "10 cm and 5 degrees beside the truth"}};
  ResultTable table{"Small-angle ICP with and without what the frustum leaves out",
                    {"images apart s", "pairs", "left out %", "precision %", "recall %", "right, all points",
                     "right, inside", "error cm (median), all points", "inside"},
                    {}};
  Tally total;
  std::size_t most_outside = 0;
  for (const double apart : aparts) {
    Tally tally;
    for (const RegistrationPair& pair :
         store.pairs({"office", context.seeds.front(), count, apart, 0.04, least_overlap})) {
      const CulledPair culled = cull(pair, static_cast<int>(tally.all.size()));
      tally.add(culled);
      total.add(culled);
      if (culled.outside.size() <= most_outside) continue;
      most_outside = culled.outside.size();
      result.charts = {three_sets(pair, culled)};
    }
    table.rows.push_back({apart, tally.all.size(), number(100 * tally.outside_share()),
                          number(100 * tally.agreeing.precision()), number(100 * tally.agreeing.recall()),
                          tally.right_all, tally.right_culled, number(100 * tally.median_all()),
                          number(100 * tally.median_culled())});
  }
  result.tables = {table};
  const bool more_right = total.right_culled >= total.right_all,
             nearer = total.median_culled() < total.median_all();
  result.agreement = more_right && nearer   ? Agreement::agrees
                     : more_right || nearer ? Agreement::agrees_in_part
                                            : Agreement::differs;
  result.finding = fmt::format(
      "From a start 10 cm and 5 degrees off the frustum leaves out {:.0f} % of the points; {:.1f} % of what "
      "it keeps the "
      "target's camera could see, and {:.1f} % of what that could see is kept. ICP's error is {:.1f} cm with "
      "it and {:.1f} cm "
      "without, right in {} and {} of {} pairs.",
      100 * total.outside_share(), 100 * total.agreeing.precision(), 100 * total.agreeing.recall(),
      100 * total.median_culled(), 100 * total.median_all(), total.right_culled, total.right_all,
      total.all.size());
  return result;
}

}  // namespace

Experiment frustum_experiment(const SharedPairs& pairs) {
  return {"frustum", "Culling by the target's frustum", "figure 3.16",
          [pairs](const StudyContext& context) { return study_frustum(context, *pairs); }};
}

}  // namespace lcmslam
