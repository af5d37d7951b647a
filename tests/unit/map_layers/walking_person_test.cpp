// A person (a pillar) walks through the simulated kitchen, seen by both sensor heads with their noise, their
// holes and the filter that the live map uses: 0.3 s after she is seen through she must be gone.

#include <gtest/gtest.h>

#include <set>

#include <lcmslam/imaging/depth_filter.hpp>
#include <lcmslam/map_layers/depth_carver.hpp>
#include <lcmslam/simulation/sensor_head.hpp>
#include <lcmslam/simulation/shapes.hpp>

#include "tests/support/source_folder.hpp"

namespace lcmslam {
namespace {

constexpr int at_30_hz = 1, at_10_hz = 3;  // of the images, each or each third
constexpr int standing = 9, walking = 30, after = 9;
constexpr int noises = 3;  // different images of the kitchen alone

const Scene& kitchen() {
  static const Scene scene = load_scene(source_folder() / "config/scenes/kitchen.yaml");
  return scene;
}

Eigen::Isometry3d T_world_camera() {
  const Eigen::Vector2d at = kitchen().path.front(), towards = kitchen().path[1] - at;
  return planar_pose(at.x(), at.y(), std::atan2(towards.y(), towards.x())) * Eigen::Translation3d(0, 0, 1.2) *
         Eigen::AngleAxisd(0.2, Eigen::Vector3d::UnitY()) * optical_axes();
}

/// Two metres ahead of the camera, from the left to the right at 0.8 m/s.
Eigen::Isometry3f person_at(double seconds) {
  const Eigen::Vector3d ahead =
      T_world_camera() * (Eigen::Vector3d(-0.4 + 0.8 * seconds, 0, 1.6) / std::cos(0.2));
  return Eigen::Isometry3f(
      Eigen::Translation3f(static_cast<float>(ahead.x()), static_cast<float>(ahead.y()), 0));
}

/// What a head sees at 30 Hz: the kitchen alone, and while she walks.
struct Film {
  CameraModel camera;
  std::vector<cv::Mat> alone, walk;

  Film(const std::string& head, cv::Size size) {
    for (int i = 0; i < noises; ++i) alone.push_back(render(kitchen(), head, size, i));
    for (int i = 0; i < walking; ++i) {
      Scene scene = kitchen();
      ShapeBuilder(scene.triangles).cylinder(person_at(i / 30.0), 0.2f, 0.2f, 1.7f, true, {}, {});
      walk.push_back(render(scene, head, size, noises + i));
    }
  }
  const cv::Mat& without_her(int image) const { return alone[static_cast<std::size_t>(image % noises)]; }
  const cv::Mat& with_her(int image) const {
    const bool there = image >= standing && image < standing + walking;
    return there ? walk[static_cast<std::size_t>(image - standing)] : without_her(image);
  }

 private:
  cv::Mat render(const Scene& scene, const std::string& name, cv::Size size, int number) {
    const RayCaster caster(scene);
    const SensorHead head = make_head(name, scene, caster, size);
    camera = head.calibration.depth;
    RgbdFrame frame;
    head.depth->render(T_world_camera(), PixelNoise(7, 1, static_cast<std::uint64_t>(number)), 1, frame);
    DepthFilter filter(head.calibration);
    filter(frame.depth, frame.amplitude);
    return frame.depth;
  }
};

std::set<std::uint64_t> occupied(const OccupancyGrid& grid) {
  std::set<std::uint64_t> cells;
  BlockLogOdds values;
  for (const Eigen::Vector3i& block : grid.blocks()) {
    grid.load(block, values);
    for (int i = 0; i < block_cells; ++i)
      if (state_of(values[static_cast<std::size_t>(i)]) == CellState::occupied)
        cells.insert(voxel_key(cell_at(block, i)));
  }
  return cells;
}

Eigen::Vector3d centre_of(std::uint64_t key, const OccupancyGrid& grid) {
  const auto part = [&](int shift) { return static_cast<int>(key >> shift & 0x1fffff) - (1 << 20); };
  return grid.centre_of(Eigen::Vector3i(part(42), part(21), part(0))).cast<double>();
}

/// Whether she was at the point or within 0.1 m of it: what noise hits farther away is not her.
bool was_hers(const Eigen::Vector3d& point) {
  for (int i = 0; i < walking; ++i)
    if ((person_at(i / 30.0).translation().cast<double>() - point).head<2>().norm() < 0.3) return true;
  return false;
}

/// Whether an image of the kitchen alone measured there what lies behind the point by 0.1 m.
bool is_seen_through(const Eigen::Vector3d& point, const Film& film) {
  const Eigen::Vector3d p = T_world_camera().inverse() * point;
  const auto pixel = film.camera.project(p);
  if (!pixel || !film.camera.contains(*pixel)) return false;
  const int u = static_cast<int>(std::lround(pixel->x())), v = static_cast<int>(std::lround(pixel->y()));
  return 0.001 * film.alone[0].at<std::uint16_t>(v, u) > p.z() + 0.1;
}

struct Outcome {
  std::size_t hers = 0, ghosts = 0, truth = 0, lost = 0;
};

Outcome carve(const Film& film, int every) {
  OccupancyGrid with({}), without({});
  DepthCarver carver;
  std::set<std::uint64_t> ever;  // occupied while she walked
  for (int i = 0; i < standing + walking + after; i += every) {
    carver.carve(film.without_her(i), film.camera, T_world_camera(), without);
    carver.carve(film.with_her(i), film.camera, T_world_camera(), with);
    if (i >= standing && i < standing + walking && i % 3 == 0)
      for (const std::uint64_t cell : occupied(with)) ever.insert(cell);
  }
  const auto truth = occupied(without), kept = occupied(with);
  Outcome outcome;
  for (const std::uint64_t cell : ever) {
    const Eigen::Vector3d point = centre_of(cell, with);
    if (truth.count(cell) > 0 || !was_hers(point) || !is_seen_through(point, film)) continue;
    ++outcome.hers;
    outcome.ghosts += kept.count(cell);
  }
  outcome.truth = truth.size();
  for (const std::uint64_t cell : truth) outcome.lost += kept.count(cell) == 0 ? 1U : 0U;
  return outcome;
}

void expect_gone(const std::string& head, cv::Size size) {
  const Film film(head, size);
  for (const int every : {at_10_hz, at_30_hz}) {
    SCOPED_TRACE(head + " at " + std::to_string(30 / every) + " Hz");
    const Outcome outcome = carve(film, every);
    std::cout << head << " at " << 30 / every << " Hz: hers " << outcome.hers << ", left " << outcome.ghosts
              << "; static " << outcome.truth << ", lost " << outcome.lost << "\n";
    EXPECT_GT(outcome.hers, 200U);
    EXPECT_GT(outcome.truth, 3000U);
    EXPECT_LT(static_cast<double>(outcome.ghosts), 0.02 * static_cast<double>(outcome.hers));
    EXPECT_LT(static_cast<double>(outcome.lost), 0.02 * static_cast<double>(outcome.truth));
  }
}

TEST(WalkingPerson, IsGoneAfterThreeTenthsOfASecondForStructuredLight) {
  expect_gone("rgbd", {320, 240});
}

TEST(WalkingPerson, IsGoneAfterThreeTenthsOfASecondForTimeOfFlight) {
  expect_gone("tof", {88, 72});
}

}  // namespace
}  // namespace lcmslam
