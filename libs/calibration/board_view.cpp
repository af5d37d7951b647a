#include <lcmslam/calibration/board_view.hpp>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <opencv2/aruco/charuco.hpp>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

#include <lcmslam/calibration/corner_fit.hpp>

namespace lcmslam {
namespace {

constexpr double widest_window = 42;    // pixels: behind a lens no edge is straight farther out
constexpr double widest_fit = 12;       // pixels, of the image as it is
constexpr int comfortable_width = 500;  // pixels: detectors are made for larger images than a ToF camera's

std::optional<BoardView> find_markers(const cv::Mat& grey, const Board& board) {
  const BoardSettings& s = board.settings();
  const auto dictionary = cv::aruco::getPredefinedDictionary(Board::dictionary());
  const auto charuco = cv::aruco::CharucoBoard::create(s.columns, s.rows, static_cast<float>(s.square),
                                                       static_cast<float>(s.marker * s.square), dictionary);
  std::vector<std::vector<cv::Point2f>> markers;
  std::vector<int> marker_ids, ids;
  cv::aruco::detectMarkers(grey, dictionary, markers, marker_ids);
  if (marker_ids.empty()) return std::nullopt;
  std::vector<cv::Point2f> corners;
  cv::aruco::interpolateCornersCharuco(markers, marker_ids, grey, charuco, corners, ids);
  BoardView view;
  for (std::size_t i = 0; i < ids.size(); ++i) {
    view.ids.push_back(ids[i]);
    view.pixels.emplace_back(corners[i].x, corners[i].y);
  }
  return view;
}

/// Whether the board's first square is the black one: the detector does not know which end is which.
bool is_turned(const cv::Mat& grey, const std::vector<cv::Point2f>& corners, int across) {
  const auto n = static_cast<std::size_t>(across);
  const auto brightness = [&](std::size_t first) {
    const cv::Point2f p =
        0.25F * (corners[first] + corners[first + 1] + corners[first + n] + corners[first + n + 1]);
    cv::Mat patch;
    cv::getRectSubPix(grey, {3, 3}, p, patch);
    return cv::mean(patch)[0];
  };
  // The inner square beside the first corner has the colour of the square in the origin: black.
  return brightness(0) > brightness(corners.size() - n - 2);
}

std::optional<BoardView> find_checkerboard(const cv::Mat& grey, const Board& board) {
  const cv::Size inner(board.settings().columns - 1, board.settings().rows - 1);
  std::vector<cv::Point2f> corners;
  const int flags = cv::CALIB_CB_ADAPTIVE_THRESH | cv::CALIB_CB_NORMALIZE_IMAGE | cv::CALIB_CB_FAST_CHECK;
  if (!cv::findChessboardCorners(grey, inner, corners, flags)) return std::nullopt;
  if (is_turned(grey, corners, inner.width)) std::reverse(corners.begin(), corners.end());
  BoardView view;
  view.ids.resize(corners.size());
  std::iota(view.ids.begin(), view.ids.end(), 0);
  for (const cv::Point2f& c : corners) view.pixels.emplace_back(c.x, c.y);
  return view;
}

/// Around a corner there is nothing but the four squares' edges within this share of the corners' distance:
/// no marker's either.
double undisturbed(const Board& board) {
  return 0.64 * (board.has_markers() ? 1 - board.settings().marker : 1);
}

/// Least distance between corners, pixels.
double spacing(const BoardView& view) {
  double least = 1e9;
  for (std::size_t i = 0; i < view.pixels.size(); ++i)
    for (std::size_t k = 0; k < i; ++k) least = std::min(least, (view.pixels[i] - view.pixels[k]).norm());
  return least;
}

/// Where the grey values' gradients say that the corner is.
void refine_by_gradients(const cv::Mat& grey, double radius, BoardView& view) {
  std::vector<cv::Point2f> corners;
  for (const auto& p : view.pixels)
    corners.emplace_back(static_cast<float>(p.x()), static_cast<float>(p.y()));
  const int half = std::max(2, static_cast<int>(M_SQRT1_2 * radius));
  cv::cornerSubPix(grey, corners, {half, half}, {-1, -1},
                   {cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 60, 1e-4});
  for (std::size_t i = 0; i < corners.size(); ++i) view.pixels[i] = {corners[i].x, corners[i].y};
}

/// Where a model of the image has it. Corners that look otherwise leave.
void refine_by_model(const cv::Mat& grey, const Board& board, double radius, BoardView& view) {
  std::vector<cv::Point2d> points, pixels;
  for (std::size_t i = 0; i < view.ids.size(); ++i) {
    const Eigen::Vector3d p = board.corner(view.ids[i]);
    points.emplace_back(p.x(), p.y());
    pixels.emplace_back(view.pixels[i].x(), view.pixels[i].y());
  }
  const cv::Mat H = cv::findHomography(points, pixels);  // good enough for the edges' directions
  BoardView refined{view.name, {}, {}};
  if (!H.empty()) {
    const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> h(H.ptr<double>());
    for (std::size_t i = 0; i < view.ids.size(); ++i) {
      const Eigen::Vector3d p = h * Eigen::Vector3d(points[i].x, points[i].y, 1);
      const Eigen::Matrix2d edges =
          p.z() * h.topLeftCorner<2, 2>() - p.head<2>() * h.block<1, 2>(2, 0);  // but for their length
      const auto corner = fit_corner(grey, view.pixels[i], edges, std::clamp(radius, 2.5, widest_fit));
      if (!corner) continue;
      refined.ids.push_back(view.ids[i]);
      refined.pixels.push_back(*corner);
    }
  }
  view = std::move(refined);
}

}  // namespace

std::optional<BoardView> find_board(const cv::Mat& grey, const Board& board) {
  if (grey.type() != CV_8UC1) throw std::invalid_argument("a board is found in grey images (CV_8UC1) only");
  const int factor =
      std::max(1, static_cast<int>(std::ceil(comfortable_width / static_cast<double>(grey.cols))));
  cv::Mat large = grey;
  if (factor > 1) cv::resize(grey, large, {}, factor, factor, cv::INTER_CUBIC);
  auto view = board.has_markers() ? find_markers(large, board) : find_checkerboard(large, board);
  if (!view || static_cast<int>(view->ids.size()) < fewest_corners) return std::nullopt;
  const double radius = undisturbed(board) * spacing(*view);
  refine_by_gradients(large, std::min(radius, widest_window), *view);
  for (auto& p : view->pixels) p = (p + Eigen::Vector2d(0.5, 0.5)) / factor - Eigen::Vector2d(0.5, 0.5);
  refine_by_model(grey, board, radius / factor, *view);
  if (static_cast<int>(view->ids.size()) < fewest_corners) return std::nullopt;
  return view;
}

std::optional<Eigen::Isometry3d> board_pose(const BoardView& view, const Board& board,
                                            const CameraModel& camera) {
  std::vector<cv::Point3d> points;
  std::vector<cv::Point2d> pixels;
  for (std::size_t i = 0; i < view.ids.size(); ++i) {
    const Eigen::Vector3d p = board.corner(view.ids[i]), ray = camera.ray(view.pixels[i]);
    if (!ray.allFinite()) continue;
    points.emplace_back(p.x(), p.y(), p.z());
    pixels.emplace_back(camera.fx * ray.x() + camera.cx, camera.fy * ray.y() + camera.cy);
  }
  if (points.size() < 4) return std::nullopt;
  cv::Vec3d r, t;
  const cv::Matx33d K = camera.matrix();
  if (!cv::solvePnP(points, pixels, K, cv::noArray(), r, t, false, cv::SOLVEPNP_IPPE)) return std::nullopt;
  cv::solvePnPRefineLM(points, pixels, K, cv::noArray(), r, t);
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = so3_exp({r[0], r[1], r[2]});
  T.translation() << t[0], t[1], t[2];
  if (!T.matrix().allFinite() || !(t[2] > 0)) return std::nullopt;
  return T;
}

}  // namespace lcmslam
