// Thesis, figures 2.3 to 2.5: the kitchen by FastSLAM. Images with the landmarks that their features were
// taken for, the map from the front and from above, and how far landmarks lie from the true surfaces.

#include <fmt/format.h>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "tools/study/report/map_pictures.hpp"
#include "tools/study/report/mapping_parts.hpp"
#include "tools/study/report/mapping_run.hpp"
#include "tools/study/report/result_parts.hpp"

namespace lcmslam {
namespace {

const cv::Scalar seen_again(178, 114, 0), refused(0, 94, 213), made(115, 158, 0);  // BGR, Okabe and Ito

/// (The high bits of an id name the map; here is one.) The image with what became of its features, the ids of
/// every few landmarks that were seen again.
cv::Mat annotated(const cv::Mat& image, const associations_t& associations) {
  cv::Mat picture = image.clone();
  int again = 0;
  for (const association_t& a : associations.associations) {
    const cv::Point at(cvRound(a.x), cvRound(a.y));
    const bool is_again = a.outcome == association_t::ACCEPTED || a.outcome == association_t::UNUSED;
    const cv::Scalar colour = is_again ? seen_again : a.outcome == association_t::CREATED ? made : refused;
    cv::circle(picture, at, 4, colour, 2, cv::LINE_AA);
    if (!is_again || again++ % 8 != 0) continue;
    for (const bool shadow : {true, false})
      cv::putText(picture, std::to_string(a.landmark & 0x7fffffff), at + cv::Point(6, -4),
                  cv::FONT_HERSHEY_SIMPLEX, 0.5, shadow ? cv::Scalar(255, 255, 255) : cv::Scalar(0, 0, 0),
                  shadow ? 4 : 1, cv::LINE_AA);
  }
  return picture;
}

cv::Mat image_sequence(const Drive& drive, const MappingRun& run) {
  cv::Mat rows[2];
  for (std::size_t i = 0; i < 4; ++i) {
    const associations_t& a = run.associations[(i + 1) * (run.associations.size() - 1) / 4];
    const cv::Mat picture = annotated(colour_image(drive, a.utime), a);
    cv::Mat& row = rows[i / 2];
    if (row.empty())
      row = picture;
    else
      cv::hconcat(row, picture, row);
  }
  cv::Mat all;
  cv::vconcat(rows[0], rows[1], all);
  return all;
}

ExperimentResult study_kitchen_landmarks(const StudyContext& context, DriveStore& drives) {
  ExperimentResult result;
  const DriveSettings usual = usual_drive(context.quick, "kitchen", 1);
  result.settings = {{"scene", "kitchen"}, {"seconds", usual.seconds}, {"frame_rate_hz", usual.frame_rate}};
  Chart chart{"Landmarks off the true surfaces",
              {"distance from the nearest true surface", "cm"},
              {"landmarks nearer than that", "%"},
              {},
              false};
  ResultTable table{"Landmark map of the kitchen",
                    {"seed", "preset", "landmarks", "median off the surface cm", "90 % cm", "pose error cm",
                     "odometry's error cm"},
                    {}};
  std::map<std::string, std::vector<double>> off, errors, wheels;
  for (const int seed : context.seeds) {
    result.seeds.push_back(seed);
    const auto drive = drives.drive(usual_drive(context.quick, "kitchen", seed));
    const std::vector<std::string> presets = {"thesis", "modern"};
    std::vector<MappingRun> runs(presets.size());
    run_side_by_side(presets.size(), [&](std::size_t i) {
      MapperChoice choice;
      choice.preset = presets[i];
      choice.icp = false;
      choice.seed = seed;
      runs[i] = map_drive(*drive, choice);
    });
    for (std::size_t i = 0; i < presets.size(); ++i) {
      const MappingRun& run = runs[i];
      const Eigen::Isometry3d T = fit_to_truth(drive->truth, run.fastslam);
      const auto distances = surface_distances(*drive, T, places_of(run.landmarks));
      off[presets[i]].push_back(quantile_of(distances, 0.5));
      errors[presets[i]].push_back(path_error(drive->truth, run.fastslam));
      wheels[presets[i]].push_back(path_error(drive->truth, run.odometry));
      table.rows.push_back({seed, presets[i], run.landmarks.size(), number(100 * off[presets[i]].back()),
                            number(100 * quantile_of(distances, 0.9)),
                            number(100 * errors[presets[i]].back()),
                            number(100 * wheels[presets[i]].back())});
      if (seed != context.seeds.front()) continue;
      chart.series.push_back(distribution_series(presets[i] + " preset", distances, 100));
      MapPictures pictures(context.work, "kitchen_landmarks_" + presets[i]);
      pictures.landmarks = &run.landmarks;
      pictures.T_world_map = T;
      pictures.paths = {{"truth", {0, 0, 0}, drive->truth, Eigen::Isometry3d::Identity()},
                        {"FastSLAM", {178, 114, 0}, run.fastslam, T}};
      pictures.add_views(result, "Landmark map by FastSLAM, " + presets[i] + " preset");
      if (presets[i] == "modern")
        result.pictures.push_back(pictures.add(
            image_sequence(*drive, run), "images", "Four images and what became of their features",
            "Circles on four images of the kitchen: blue are landmarks seen again, every eighth with its id; "
            "green are new landmarks; orange were refused."));
    }
    context.progress(static_cast<double>(result.seeds.size()) / static_cast<double>(context.seeds.size()));
  }
  result.charts = {chart};
  result.tables = {table};
  const double ours = spread_of(off["thesis"]).median, best = spread_of(off["modern"]).median;
  const bool better = spread_of(errors["thesis"]).median < spread_of(wheels["thesis"]).median;
  result.agreement = better ? Agreement::agrees : Agreement::differs;
  result.finding = fmt::format(
      "Half of the landmarks lie within {} of a true surface with the thesis's preset and within {} with the "
      "modern one ({} is better); the thesis's filter errs by {} where the wheels err by {}, so it {} the "
      "odometry.",
      in_words(off["thesis"], 100, "cm"), in_words(off["modern"], 100, "cm"),
      best < ours ? "modern" : "the thesis's", in_words(errors["thesis"], 100, "cm"),
      in_words(wheels["thesis"], 100, "cm"), better ? "improves on" : "does not improve on");
  return result;
}

}  // namespace

Experiment kitchen_landmarks_experiment(const SharedDrives& drives) {
  return {"kitchen-landmarks", "The kitchen by FastSLAM", "figures 2.3 to 2.5",
          [drives](const StudyContext& context) { return study_kitchen_landmarks(context, *drives); }};
}

}  // namespace lcmslam
