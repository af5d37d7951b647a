#pragma once
// Somebody holds a board before cameras whose truth is drawn from a seed.

#include <lcmslam/calibration/camera_pair.hpp>
#include "tests/support/board_renderer.hpp"

namespace lcmslam::testing {

/// 640x480, about 60 degrees, focal length and principal point drawn by some per cent.
inline CameraModel drawn_colour_camera(std::uint64_t seed) {
  Random random(seed, 17);
  CameraModel c;
  c.width = 640, c.height = 480;
  c.fx = 554 * (1 + random.uniform(-0.05, 0.05));
  c.fy = c.fx * (1 + random.uniform(-0.005, 0.005));
  c.cx = 319.5 + random.uniform(-12, 12), c.cy = 239.5 + random.uniform(-12, 12);
  c.distortion = {random.uniform(-0.15, -0.05), random.uniform(0.02, 0.07), random.uniform(-1e-3, 1e-3),
                  random.uniform(-1e-3, 1e-3), 0};
  return c;
}

/// 176x144, about 47 degrees, as time-of-flight cameras have it.
inline CameraModel drawn_tof_camera(std::uint64_t seed) {
  Random random(seed, 18);
  CameraModel c;
  c.width = 176, c.height = 144;
  c.fx = 200 * (1 + random.uniform(-0.04, 0.04));
  c.fy = c.fx * (1 + random.uniform(-0.005, 0.005));
  c.cx = 87.5 + random.uniform(-3, 3), c.cy = 71.5 + random.uniform(-3, 3);
  return c;
}

/// The i-th place of a board: all over the image, near and far, tilted to every side by up to `tilt` (rad).
/// Its middle stays within `middle` of the image's middle (1: to its rim), and it fills the share `near` to
/// `far` of the width.
struct BoardPlaces {
  double tilt = 0.6, middle = 0.62, near = 0.85, far = 0.45;

  Eigen::Isometry3d operator()(int i, const Board& board, const CameraModel& camera, Random& random) const {
    static constexpr int across[9] = {0, -1, 1, -1, 1, 0, 0, -1, 1}, down[9] = {0, -1, 1, 1, -1, -1, 1, 0, 0};
    const Eigen::Vector2d half(0.5 * camera.width, 0.5 * camera.height);
    const Eigen::Vector2d pixel =
        half + middle * half.cwiseProduct(Eigen::Vector2d(across[i % 9] + random.uniform(-0.15, 0.15),
                                                          down[i % 9] + random.uniform(-0.15, 0.15)));
    const double share = far + (near - far) * random.uniform();
    const double distance = camera.fx * board.width() / (share * camera.width);
    const double sign_x = i % 2 == 0 ? 1 : -1, sign_y = (i / 2) % 2 == 0 ? 1 : -1;
    return held_board(board, camera, pixel, distance, sign_x * tilt * random.uniform(0.3, 1),
                      sign_y * tilt * random.uniform(0.3, 1), random.uniform(-0.2, 0.2));
  }
};

/// As the detector finds them in rendered images.
inline std::vector<BoardView> colour_views(const Board& board, const CameraModel& camera, int count,
                                           std::uint64_t seed) {
  Random random(seed, 19);
  const BoardRenderer render(board, camera);
  std::vector<BoardView> views;
  for (int i = 0; i < count; ++i) {
    auto view = find_board(render(BoardPlaces()(i, board, camera, random), random), board);
    if (!view) continue;
    view->name = "view " + std::to_string(i);
    views.push_back(std::move(*view));
  }
  return views;
}

/// Projected corners with noise (pixels), nothing rendered.
inline std::vector<BoardView> exact_views(const Board& board, const CameraModel& camera, int count,
                                          std::uint64_t seed, double noise, double tilt = 0.6) {
  Random random(seed, 20);
  BoardPlaces places;
  places.tilt = tilt;
  std::vector<BoardView> views;
  for (int i = 0; i < count; ++i) {
    const Eigen::Isometry3d T = places(i, board, camera, random);
    BoardView view;
    for (int id = 0; id < board.corners(); ++id) {
      const auto pixel = camera.project(T * board.corner(id));
      if (!pixel || !camera.contains(*pixel)) continue;
      view.ids.push_back(id);
      view.pixels.emplace_back(*pixel + noise * Eigen::Vector2d(random.normal(), random.normal()));
    }
    views.push_back(std::move(view));
  }
  return views;
}

/// A board that a ToF camera's few pixels still resolve: a checkerboard of 64 x 56 cm.
inline Board large_board() {
  BoardSettings settings;
  settings.kind = "checkerboard";
  settings.columns = 8, settings.rows = 7, settings.square = 0.08;
  return Board(settings);
}

struct RgbdTruth {
  RgbdCalibration calibration;  ///< both cameras and how they sit on each other
  double noise = 0.001;         ///< 1/m, of the range: noise r^2 / sqrt(reflectivity cos(incidence))
};

inline RgbdTruth drawn_head(std::uint64_t seed) {
  Random random(seed, 21);
  const auto near = [&](double value, double by) { return value + random.uniform(-by, by); };
  RgbdTruth truth;
  RgbdCalibration& c = truth.calibration;
  c.colour = drawn_colour_camera(seed);
  c.depth = drawn_tof_camera(seed);
  c.T_colour_depth.translation() << near(0.08, 0.01), near(0, 0.01), near(0, 0.01);
  c.T_colour_depth.linear() = so3_exp({near(0, 0.02), near(-0.035, 0.02), near(0, 0.02)});
  c.depth_error = {near(0.01, 0.01), 0, near(0.006, 0.002), near(1.9, 0.2), near(0, 3)};
  return truth;
}

/// A ToF camera's depth image of the board before a wall that is 4 m away. CV_16UC1 mm.
inline cv::Mat board_depth(const Board& board, const RgbdTruth& truth, const Eigen::Isometry3d& T_depth_board,
                           Random& random) {
  const CameraModel& camera = truth.calibration.depth;
  cv::Mat depth(camera.height, camera.width, CV_16UC1);
  const Eigen::Vector3d normal = T_depth_board.linear().col(2);
  const double margin = 0.5 * board.settings().square, wall = 4;
  for (int v = 0; v < depth.rows; ++v)
    for (int u = 0; u < depth.cols; ++u) {
      const Eigen::Vector3d ray = camera.ray({u, v});
      double z = normal.dot(T_depth_board.translation()) / normal.dot(ray);
      const Eigen::Vector3d p = T_depth_board.inverse() * (z * ray);
      const bool beside = p.x() < -margin || p.y() < -margin || p.x() > board.width() + margin ||
                          p.y() > board.height() + margin;
      if (!(z > 0) || beside) z = wall;
      const bool black = (static_cast<int>(std::floor(p.x() / board.settings().square)) +
                          static_cast<int>(std::floor(p.y() / board.settings().square))) %
                             2 ==
                         0;
      const double range = z * ray.norm(), cosine = std::abs(normal.dot(ray)) / ray.norm();
      const double reflectivity = black && !beside ? 0.1 : 0.8;
      const double sigma = truth.noise * range * range / std::sqrt(reflectivity * std::max(0.05, cosine));
      const double measured = range + truth.calibration.depth_error.at(range) + random.normal(0, sigma);
      depth.at<std::uint16_t>(v, u) = static_cast<std::uint16_t>(1000 * measured / ray.norm() + 0.5);
    }
  return depth;
}

struct HeadShots {
  std::vector<PairView> pairs;  ///< those in which both cameras see the board
  std::vector<cv::Mat> depths;  ///< of the pairs
};

/// The board is held before the depth camera, at 0.7 to 3 m.
inline HeadShots head_shots(const Board& board, const RgbdTruth& truth, int count, std::uint64_t seed) {
  Random random(seed, 22);
  const RgbdCalibration& c = truth.calibration;
  const BoardRenderer colour(board, c.colour), depth(board, c.depth, {0.5, 3, 5});
  HeadShots shots;
  for (int i = 0; i < count; ++i) {
    BoardPlaces places;
    const double share = 0.85 / (1 + 3.0 * i / count);  // of the image's width: from near to far
    places.near = share, places.far = 0.92 * share;
    places.middle = 0.8 * (1 - share);
    places.tilt = 0.55;
    const Eigen::Isometry3d T_depth_board = places(i, board, c.depth, random);
    auto in_colour = find_board(colour(c.T_colour_depth * T_depth_board, random), board);
    auto in_depth = find_board(depth(T_depth_board, random), board);
    const cv::Mat measured = board_depth(board, truth, T_depth_board, random);
    if (!in_colour || !in_depth) continue;
    in_colour->name = in_depth->name = "shot " + std::to_string(i);
    shots.pairs.push_back({std::move(*in_colour), std::move(*in_depth)});
    shots.depths.push_back(measured);
  }
  return shots;
}

}  // namespace lcmslam::testing
