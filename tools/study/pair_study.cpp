#include "tools/study/pair_study.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <opencv2/core/utility.hpp>
#include <stdexcept>

#include <lcmslam/evaluation/table.hpp>
#include <lcmslam/evaluation/trajectory.hpp>
#include <lcmslam/imaging/io/codec.hpp>
#include <lcmslam/imaging/io/encoded_frame.hpp>
#include <lcmslam/runtime/machine.hpp>
#include <lcmslam/surf/surf.hpp>
#include "tools/study/feature_study.hpp"
#include "tools/study/measures.hpp"
#include "tools/study/pair_view.hpp"

namespace lcmslam {
namespace {

constexpr double degrees = 180 / 3.14159265358979323846;

/// A recording in memory: its images as they came, and where the camera was.
struct Recording {
  RgbdCalibration calibration;
  std::vector<EncodedFrame> frames;
  Trajectory truth;  // of the colour camera
};

Recording read(CameraSource& source) {
  Recording recording;
  recording.calibration = source.calibration();
  while (auto event = source.next()) {
    if (auto* frame = std::get_if<EncodedFrame>(&*event)) {
      recording.frames.push_back(std::move(*frame));
    } else if (const auto* truth = std::get_if<GroundTruth>(&*event)) {
      Eigen::Isometry3d T = truth->T_world_child;
      if (truth->child_frame == "robot") T = T * recording.calibration.T_robot_camera;
      recording.truth.push_back({truth->utime, T});
    }
  }
  if (recording.truth.empty())
    throw std::invalid_argument("the recording has no true poses, which a pair study needs");
  return recording;
}

class PairStudy {
 public:
  PairStudy(CameraSource& source, const std::vector<PairMethod>& methods, const PairStudySettings& settings)
      : recording_(read(source)),
        registration_(recording_.calibration),
        methods_(methods),
        settings_(settings) {}

  PairStudyResult run() {
    const OneThread one_thread;
    for (const std::size_t start :
         spread_starts(recording_.frames.size(), settings_.apart.back(), settings_.starts)) {
      const auto target = view(start);
      for (const int apart : settings_.apart) {
        const auto source = view(start + static_cast<std::size_t>(apart));
        if (target && source)
          judge(*source, *target, apart);
        else
          ++result_.unreadable;
      }
    }
    finish();
    return result_;
  }

 private:
  std::optional<PairView> view(std::size_t index) {
    try {
      return make_pair_view(decode(recording_.frames[index]), registration_, settings_.voxel_size, surf_);
    } catch (const std::runtime_error&) {
      return std::nullopt;  // a damaged image
    }
  }

  /// Clouds stand where the camera was at the depth images' times.
  std::optional<Eigen::Isometry3d> true_pose(const PairView& view) const {
    const auto offset = static_cast<Utime>(std::llround(1e6 * settings_.truth_offset));
    return pose_at(recording_.truth, view.depth_utime + offset);
  }

  void judge(const PairView& source, const PairView& target, int apart) {
    const auto T_world_source = true_pose(source), T_world_target = true_pose(target);
    if (!T_world_source || !T_world_target) {
      ++result_.unreadable;
      return;
    }
    const Eigen::Isometry3d truth = T_world_target->inverse() * *T_world_source;
    if (pair_overlap(source, target, truth, 2 * settings_.voxel_size) < settings_.min_overlap) {
      ++result_.little_overlap;
      return;
    }
    for (const PairMethod& method : methods_) {
      Tally& tally = tallies_[{method.name, apart}];
      const double before = thread_cpu_seconds();
      const auto T = method.solve(source, target);
      tally.milliseconds.push_back(1e3 * (thread_cpu_seconds() - before));
      if (!T) {
        tally.misses.push_back({source.utime, target.utime, NAN, NAN});
        continue;
      }
      ++tally.solved;
      const Eigen::Isometry3d error = truth.inverse() * *T;
      const double translation = error.translation().norm(), rotation = degrees * rotation_angle(error);
      if (!(translation <= settings_.max_translation && rotation <= settings_.max_rotation)) {
        tally.misses.push_back({source.utime, target.utime, translation, rotation});
        continue;
      }
      tally.translations.push_back(translation);
      tally.rotations.push_back(rotation);
    }
  }

  void finish() {
    for (const PairMethod& method : methods_)
      for (const int apart : settings_.apart) {
        const Tally& tally = tallies_[{method.name, apart}];
        PairScore score;
        score.method = method.name;
        score.apart = apart;
        score.pairs = static_cast<int>(tally.milliseconds.size());
        score.solved = tally.solved;
        score.right = static_cast<int>(tally.translations.size());
        score.median_translation = median(tally.translations);
        score.median_rotation = median(tally.rotations);
        score.milliseconds = median(tally.milliseconds);
        score.misses = tally.misses;
        result_.scores.push_back(score);
      }
  }

  struct Tally {
    int solved = 0;
    std::vector<double> translations, rotations;  // of the right ones
    std::vector<double> milliseconds;
    std::vector<PairMiss> misses;
  };

  Recording recording_;
  DepthRegistration registration_;
  const std::vector<PairMethod>& methods_;
  const PairStudySettings& settings_;
  Surf surf_;
  std::map<std::pair<std::string, int>, Tally> tallies_;
  PairStudyResult result_;
};

}  // namespace

void PairStudySettings::check() const {
  const auto refuse = [](const std::string& what) { throw std::invalid_argument("pair study: " + what); };
  if (apart.empty() || apart.front() < 1 || !std::is_sorted(apart.begin(), apart.end()))
    refuse("the frames between the images of a pair must be ascending numbers from 1 on");
  if (starts < 1) refuse(fmt::format("{} starts; at least 1", starts));
  if (!(voxel_size > 0)) refuse(fmt::format("voxels of {} m; must be positive", voxel_size));
  if (!(max_translation > 0 && max_rotation > 0)) refuse("the limits of a right result must be positive");
  if (!std::isfinite(truth_offset)) refuse("the clock offset must be a number");
}

PairStudyResult study_pairs(CameraSource& source, const std::vector<PairMethod>& methods,
                            const PairStudySettings& settings) {
  settings.check();
  return PairStudy(source, methods, settings).run();
}

std::string pair_table(const PairStudyResult& result) {
  Table table({"method", "apart", "pairs", "solved", "right", "%", "m", "deg", "ms"});
  for (const PairScore& s : result.scores)
    table.add({s.method, std::to_string(s.apart), std::to_string(s.pairs), std::to_string(s.solved),
               std::to_string(s.right), fixed_number(s.pairs > 0 ? 100.0 * s.right / s.pairs : NAN, 0),
               fixed_number(s.median_translation, 3), fixed_number(s.median_rotation, 2),
               fixed_number(s.milliseconds, 1)});
  return fmt::format("{}left out: {} pairs with too little overlap, {} that could not be read\n",
                     table.text(), result.little_overlap, result.unreadable);
}

nlohmann::json pair_json(const PairStudyResult& result, const PairStudySettings& settings) {
  nlohmann::json report = {{"starts", settings.starts},
                           {"voxel_size_m", settings.voxel_size},
                           {"max_translation_m", settings.max_translation},
                           {"max_rotation_deg", settings.max_rotation},
                           {"min_overlap", settings.min_overlap},
                           {"truth_offset_s", settings.truth_offset},
                           {"little_overlap", result.little_overlap},
                           {"unreadable", result.unreadable}};
  for (const PairScore& s : result.scores) {
    const auto number = [](double v) { return std::isfinite(v) ? nlohmann::json(v) : nlohmann::json(); };
    nlohmann::json misses = nlohmann::json::array();
    for (const PairMiss& m : s.misses)
      misses.push_back({{"source_utime", m.source},
                        {"target_utime", m.target},
                        {"translation_m", number(m.translation)},
                        {"rotation_deg", number(m.rotation)}});
    report["scores"].push_back({{"method", s.method},
                                {"apart", s.apart},
                                {"pairs", s.pairs},
                                {"solved", s.solved},
                                {"right", s.right},
                                {"median_translation_m", number(s.median_translation)},
                                {"median_rotation_deg", number(s.median_rotation)},
                                {"milliseconds", number(s.milliseconds)},
                                {"misses", misses}});
  }
  return report;
}

}  // namespace lcmslam
