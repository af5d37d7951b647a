#include "tools/study/depth_filter_study.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include <lcmslam/evaluation/table.hpp>
#include <lcmslam/runtime/machine.hpp>
#include <lcmslam/simulation/planar_path.hpp>
#include <lcmslam/simulation/sensor_head.hpp>
#include "tools/study/measures.hpp"

namespace lcmslam {
namespace {

constexpr std::int64_t fewest_mixed = 50;
constexpr std::uint64_t depth_sensor = 2;

struct LabelledImage {
  cv::Mat depth, amplitude;
  cv::Mat classes;  // DepthClass
  cv::Mat gap;      // tolerances
};

struct Case {
  std::string scene, head;
  RgbdCalibration calibration;
  std::vector<LabelledImage> images;
};

Case render(const std::string& file, const std::string& head_name, cv::Size size,
            const DepthFilterStudySettings& settings) {
  const Scene scene = load_scene(file);
  const RayCaster caster(scene);
  const SensorHead head = make_head(head_name, scene, caster, size);
  const RgbdCalibration& calibration = head.calibration;
  const DepthTruth truth(scene, caster, calibration.depth, head.tolerance);
  const PlanarPath path(scene.path);
  Case result{scene.name, head_name, calibration, {}};
  for (int i = 0; i < settings.images; ++i) {
    const Eigen::Isometry3d T_world_depth = path.pose(path.duration() * (i + 0.5) / settings.images) *
                                            calibration.T_robot_camera * calibration.T_colour_depth;
    RgbdFrame frame;
    head.depth->render(T_world_depth, PixelNoise(settings.seed, depth_sensor, i), 1, frame);
    LabelledImage image{frame.depth, frame.amplitude, {}, {}};
    image.classes = truth.classify(frame.depth, frame.amplitude, T_world_depth, 1, &image.gap);
    result.images.push_back(image);
  }
  return result;
}

bool is(const LabelledImage& image, int i, DepthClass wanted) {
  return image.classes.data[i] == static_cast<std::uint8_t>(wanted);
}

DepthFilterScore score(const Case& data, const DepthFilterMethod& method) {
  DepthFilterScore result;
  result.scene = data.scene, result.head = data.head, result.method = method.name;
  result.size = {data.calibration.depth.width, data.calibration.depth.height};
  const auto filter = method.make(data.calibration);
  std::vector<double> times, gaps;
  for (const LabelledImage& image : data.images) {
    cv::Mat depth = image.depth.clone();
    const double before = thread_cpu_seconds();
    filter(depth, image.amplitude);
    times.push_back(1e3 * (thread_cpu_seconds() - before));
    for (int i = 0; i < static_cast<int>(depth.total()); ++i) {
      const bool removed = depth.ptr<std::uint16_t>()[i] == 0;
      if (is(image, i, DepthClass::good)) ++result.good, result.good_removed += removed;
      if (!is(image, i, DepthClass::mixed)) continue;
      ++result.mixed, result.mixed_removed += removed;
      if (!removed) gaps.push_back(static_cast<double>(image.gap.ptr<float>()[i]));
    }
  }
  result.left_gap = median(gaps);
  result.milliseconds = median(times);
  return result;
}

nlohmann::json number_or_null(double value) {
  return std::isfinite(value) ? nlohmann::json(value) : nlohmann::json();
}

}  // namespace

double DepthFilterScore::removed_share() const {
  if (mixed < fewest_mixed) return std::numeric_limits<double>::quiet_NaN();
  return static_cast<double>(mixed_removed) / static_cast<double>(mixed);
}

double DepthFilterScore::lost_share() const {
  return good > 0 ? static_cast<double>(good_removed) / static_cast<double>(good) : 0;
}

void DepthFilterStudySettings::check() const {
  if (scenes.empty() || heads.empty() || sizes.empty())
    throw std::invalid_argument("a depth filter study needs scenes, heads and sizes");
  if (images < 1) throw std::invalid_argument("a depth filter study needs at least one image");
}

DepthFilterStudyResult study_depth_filter(const std::vector<DepthFilterMethod>& methods,
                                          const DepthFilterStudySettings& settings) {
  settings.check();
  const OneThread one_thread;
  DepthFilterStudyResult result;
  for (const double sigmas : settings.curve) result.curve.push_back({sigmas});
  for (const std::string& head : settings.heads)
    for (const cv::Size size : settings.sizes)
      for (const std::string& scene : settings.scenes) {
        const Case data = render(scene, head, size, settings);
        for (const DepthFilterMethod& method : methods) result.scores.push_back(score(data, method));
        for (DepthFilterPoint& point : result.curve) {
          DepthFilterSettings other;
          other.jump_edges.noise_sigmas = point.noise_sigmas;
          const DepthFilterScore s = score(data, depth_filter_methods(other).front());
          point.removed_share = std::fmin(point.removed_share, s.removed_share());
          point.lost_share = std::max(point.lost_share, s.lost_share());
        }
      }
  return result;
}

std::string depth_filter_table(const DepthFilterStudyResult& result) {
  Table table({"head, size, scene", "filter", "mixed pixels", "removed %", "good lost %", "left: gap / noise",
               "ms an image"});
  for (const DepthFilterScore& s : result.scores)
    table.add({fmt::format("{} {}x{} {}", s.head, s.size.width, s.size.height, s.scene), s.method,
               std::to_string(s.mixed), fixed_number(100 * s.removed_share(), 1),
               fixed_number(100 * s.lost_share(), 2), fixed_number(s.left_gap, 2),
               fixed_number(s.milliseconds, 2)});
  if (result.curve.empty()) return table.text();
  Table curve({"jump_edges.noise_sigmas", "least removed %", "most lost %"});
  for (const DepthFilterPoint& p : result.curve)
    curve.add({fixed_number(p.noise_sigmas, 2), fixed_number(100 * p.removed_share, 1),
               fixed_number(100 * p.lost_share, 2)});
  return table.text() + "\nworst of all rows, over the noise allowed:\n" + curve.text();
}

nlohmann::json depth_filter_json(const DepthFilterStudyResult& result,
                                 const DepthFilterStudySettings& settings) {
  nlohmann::json scores = nlohmann::json::array(), curve = nlohmann::json::array();
  for (const DepthFilterScore& s : result.scores)
    scores.push_back({{"head", s.head},
                      {"width", s.size.width},
                      {"height", s.size.height},
                      {"scene", s.scene},
                      {"filter", s.method},
                      {"mixed", s.mixed},
                      {"good", s.good},
                      {"mixed_removed", s.mixed_removed},
                      {"good_removed", s.good_removed},
                      {"left_gap", number_or_null(s.left_gap)},
                      {"milliseconds", s.milliseconds}});
  for (const DepthFilterPoint& p : result.curve)
    curve.push_back(
        {{"noise_sigmas", p.noise_sigmas}, {"least_removed", p.removed_share}, {"most_lost", p.lost_share}});
  return {{"settings", {{"images", settings.images}, {"seed", settings.seed}, {"scenes", settings.scenes}}},
          {"scores", scores},
          {"curve", curve}};
}

}  // namespace lcmslam
