#include "tools/study/feature_study.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/utility.hpp>
#include <opencv2/imgproc.hpp>

#include <lcmslam/imaging/io/codec.hpp>
#include <lcmslam/runtime/machine.hpp>
#include "tools/study/measures.hpp"

namespace lcmslam {
namespace {

/// An image, what each row sees in it, and its measured pose.
struct StudiedImage {
  StudyView view;
  Eigen::Isometry3d T_world_camera = Eigen::Isometry3d::Identity();
  std::vector<ImageFeatures> features;  // by row
};

class FeatureStudy {
 public:
  FeatureStudy(RgbdSource& source, FeatureMethods& methods, const FeatureStudySettings& settings)
      : source_(source), methods_(methods), settings_(settings), seconds_(methods.size()) {
    settings.check();
    if (source.truth().empty())
      throw std::invalid_argument("the recording has no true poses, which a feature study needs");
    result_.apart = settings.apart;
    result_.left_out.resize(settings.apart.size());
    for (const StudyRow& row : study_rows(methods))
      result_.methods.push_back({row, std::vector<DistanceScore>(settings.apart.size()), {}, 0});
    scores_.resize(result_.methods.size());
    for (auto& row : scores_) row.resize(settings.apart.size());
  }

  FeatureStudyResult run() {
    const OneThread one_thread;
    const auto starts = spread_starts(source_.size(), settings_.apart.back(), settings_.starts);
    for (auto& row : scores_)
      for (auto& by_start : row) by_start.resize(starts.size());
    for (std::size_t s = 0; s < starts.size(); ++s) {
      const std::size_t start = starts[s];
      const auto a = image(start);
      for (std::size_t d = 0; d < settings_.apart.size(); ++d) {
        const auto b = a ? image(start + static_cast<std::size_t>(settings_.apart[d])) : std::nullopt;
        if (!b)
          ++result_.unreadable;
        else
          judge(*a, *b, s, d);
      }
    }
    finish();
    return result_;
  }

 private:
  std::optional<StudiedImage> image(std::size_t index) {
    const auto frame = source_.frame(index);
    const auto pose = pose_at(source_.truth(), source_.entry(index).utime);
    if (!frame || !pose) return std::nullopt;
    StudiedImage image{study_view(decode(*frame), source_.calibration()), *pose, {}};
    if (source_.truth_frame() == "robot") image.T_world_camera = *pose * source_.calibration().T_robot_camera;
    std::vector<ImageFeatures> found;
    for (std::size_t m = 0; m < methods_.size(); ++m) {
      const double before = thread_cpu_seconds();
      const ImageFeatures features = methods_[m]->compute(image.view.grey);
      seconds_[m].push_back(thread_cpu_seconds() - before);
      found.push_back(
          with_depth(first_features(strongest_first(features), static_cast<std::size_t>(settings_.keypoints)),
                     image.view));
    }
    for (const MethodResult& method : result_.methods) {
      const StudyRow& row = method.row;
      const ImageFeatures& features = found[row.method];
      image.features.push_back(
          row.as_many_as ? first_features(features, found[*row.as_many_as].keypoints.size()) : features);
    }
    return image;
  }

  const FeatureMethod& method_of(std::size_t row) const { return *methods_[result_.methods[row].row.method]; }

  void judge(const StudiedImage& a, const StudiedImage& b, std::size_t start, std::size_t distance) {
    const std::size_t rows = result_.methods.size();
    std::vector<std::vector<cv::Vec2i>> matches(rows);
    for (std::size_t r = 0; r < rows; ++r)
      matches[r] = mutual_matches(a.features[r].descriptors, b.features[r].descriptors, method_of(r).norm(),
                                  settings_.ratio);
    const Eigen::Isometry3d T_b_a_recorded = b.T_world_camera.inverse() * a.T_world_camera;
    std::vector<Eigen::Isometry3d> poses;
    for (std::size_t r = 0; r < rows; ++r) {
      const auto T_b_a = reference_pose(pool_without(method_of(r).family(), a, b, matches), a.view.K,
                                        T_b_a_recorded, settings_.pose);
      if (!T_b_a) {
        ++result_.left_out[distance];
        return;
      }
      poses.push_back(*T_b_a);
    }
    for (std::size_t r = 0; r < rows; ++r)
      scores_[r][distance][start] = score_features(a.view, b.view, poses[r], a.features[r], b.features[r],
                                                   matches[r], settings_.tolerances);
  }

  /// Matches of the other families, each family with its first row.
  PointsAndPixels pool_without(const std::string& judged, const StudiedImage& a, const StudiedImage& b,
                               const std::vector<std::vector<cv::Vec2i>>& matches) const {
    PointsAndPixels pool;
    std::vector<std::string> seen = {judged};
    for (std::size_t r = 0; r < matches.size(); ++r) {
      const std::string family = method_of(r).family();
      if (std::find(seen.begin(), seen.end(), family) != seen.end()) continue;
      seen.push_back(family);
      add_matches(pool, a.view, b.view, a.features[r], b.features[r], matches[r]);
    }
    return pool;
  }

  static DistanceScore mean(const std::vector<std::optional<FeatureScore>>& scores) {
    DistanceScore sum;
    for (const auto& score : scores) {
      if (!score) continue;
      ++sum.pairs;
      sum.keypoints += score->keypoints;
      sum.repeatability += score->repeatability();
      sum.precision += score->precision();
      sum.correct += score->correct;
    }
    for (double* value : {&sum.keypoints, &sum.repeatability, &sum.precision, &sum.correct})
      *value /= sum.pairs;  // NaN without a pair
    return sum;
  }

  /// Starts that one pair reaches over: these share images.
  int block(int apart, std::size_t starts) const {
    const std::size_t range = source_.size() - static_cast<std::size_t>(settings_.apart.back());
    return 1 + static_cast<int>(static_cast<std::size_t>(apart) * starts / std::max<std::size_t>(1, range));
  }

  void finish() {
    std::optional<std::size_t> dlib;
    for (std::size_t r = 0; r < scores_.size(); ++r)
      if (method_of(r).family() == "dlib SURF") dlib = r;
    for (std::size_t r = 0; r < scores_.size(); ++r) {
      MethodResult& method = result_.methods[r];
      method.milliseconds = method.row.as_many_as ? std::numeric_limits<double>::quiet_NaN()
                                                  : 1e3 * median(seconds_[method.row.method]);
      for (std::size_t d = 0; d < settings_.apart.size(); ++d) {
        const auto& scores = scores_[r][d];
        method.scores[d] = mean(scores);
        if (!dlib || r == *dlib) continue;
        BootstrapSettings bootstrap;
        bootstrap.block = block(settings_.apart[d], scores.size());
        method.against_dlib.push_back(compare_scores(scores, scores_[*dlib][d], bootstrap));
      }
    }
  }

  RgbdSource& source_;
  FeatureMethods& methods_;
  const FeatureStudySettings& settings_;
  std::vector<std::vector<double>> seconds_;                                   // by method
  std::vector<std::vector<std::vector<std::optional<FeatureScore>>>> scores_;  // by row, distance, start
  FeatureStudyResult result_;
};

}  // namespace

void FeatureStudySettings::check() const {
  const auto refuse = [](const std::string& what) { throw std::invalid_argument("feature study: " + what); };
  if (apart.empty() || apart.front() < 1 || !std::is_sorted(apart.begin(), apart.end()))
    refuse("the frames between the images of a pair must be ascending numbers from 1 on");
  if (starts < 1) refuse(fmt::format("{} starts; at least 1", starts));
  if (keypoints < 2) refuse(fmt::format("{} keypoints; at least 2", keypoints));
  if (!(ratio > 0 && ratio <= 1)) refuse(fmt::format("ratio {}; above 0, at most 1", ratio));
}

std::vector<StudyRow> study_rows(const FeatureMethods& methods) {
  std::vector<StudyRow> rows;
  for (std::size_t m = 0; m < methods.size(); ++m) rows.push_back({methods[m]->name(), m, std::nullopt});
  const auto is_dlib = [](const auto& method) { return method->family() == "dlib SURF"; };
  const auto dlib = std::find_if(methods.begin(), methods.end(), is_dlib);
  if (dlib != methods.end())
    rows.insert(rows.begin() + 1,
                {methods.front()->family() + ", as many as dlib", 0, std::size_t(dlib - methods.begin())});
  return rows;
}

std::vector<std::size_t> spread_starts(std::size_t size, int reach, int count) {
  const std::size_t needed = static_cast<std::size_t>(reach) + static_cast<std::size_t>(count);
  if (size < needed)
    throw std::invalid_argument(
        fmt::format("the recording has {} frames; {} starts and pairs {} frames apart need at least {}", size,
                    count, reach, needed));
  std::vector<std::size_t> starts;
  const std::size_t last = size - 1 - static_cast<std::size_t>(reach);
  for (int i = 0; i < count; ++i)  // the middles of `count` equal parts
    starts.push_back(last * static_cast<std::size_t>(2 * i + 1) / static_cast<std::size_t>(2 * count));
  return starts;
}

StudyView study_view(const RgbdFrame& frame, const RgbdCalibration& calibration) {
  if (!calibration.depth_registered)
    throw std::invalid_argument("a feature study needs depth images registered to colour; those of " +
                                calibration.sensor + " are not");
  if (frame.colour.empty() || frame.depth.empty())
    throw std::invalid_argument(fmt::format("frame {} has no colour or no depth image", frame.seq));
  const CameraModel& camera = calibration.colour;
  cv::Mat map_x, map_y, distorted, depth;
  cv::initUndistortRectifyMap(camera.matrix(), camera.distortion, cv::noArray(), camera.matrix(),
                              {camera.width, camera.height}, CV_32FC1, map_x, map_y);
  StudyView view;
  view.K = camera.matrix();
  cv::cvtColor(frame.colour, distorted, cv::COLOR_BGR2GRAY);
  cv::remap(distorted, view.grey, map_x, map_y, cv::INTER_LINEAR);
  cv::remap(frame.depth, depth, map_x, map_y, cv::INTER_NEAREST);  // between two depths there may be nothing
  depth.convertTo(view.depth, CV_32F, 1e-3);
  return view;
}

FeatureStudyResult study_features(RgbdSource& source, FeatureMethods& methods,
                                  const FeatureStudySettings& settings) {
  return FeatureStudy(source, methods, settings).run();
}

}  // namespace lcmslam
