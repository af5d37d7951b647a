#include <lcmslam/planes/plane_rims.hpp>

#include <algorithm>
#include <cmath>

#include <lcmslam/planes/rim_pixels.hpp>

namespace lcmslam {
namespace {

constexpr int reach = 2;     // cells, from a plane to pixels that may be its own
constexpr float sure = 1;    // sigmas off the plane up to which pixels tell where it lies
constexpr int smoothed = 2;  // pixels: what BilateralFilter takes means over
constexpr double least_points = 10;
constexpr double least_share = 0.05;  // of a plane's points that must be left for another fit

using NearPlanes = std::vector<NearPlane>;

void add_near(std::uint8_t label, const PlaneEquation& plane, NearPlanes& near) {
  for (const NearPlane& other : near)
    if (other.label == label) return;
  const Eigen::Vector3f n = plane.normal.cast<float>();
  near.push_back({n.x(), n.y(), n.z(), static_cast<float>(plane.offset), label});
}

class RimFollower {
 public:
  RimFollower(const CellMoments& cells, const std::vector<std::uint8_t>& plane_of_cell,
              const FramePlanes& found)
      : cells_(cells),
        plane_of_cell_(plane_of_cell),
        found_(found),
        labels_(found.planes.size() + 1),
        bulges_(labels_ * labels_, 0) {
    for (std::size_t a = 1; a < labels_; ++a)
      for (std::size_t b = 1; b < labels_; ++b) bulges_[a * labels_ + b] = bulge_of(a - 1, b - 1);
  }

  /// Whether a cell and all around it are of the same plane.
  bool is_inner(int column, int row) const {
    const std::uint8_t own = plane(column, row);
    bool inner = own != 0;
    for_around(column, row, 1, [&](std::uint8_t other) { inner = inner && other == own; });
    return inner;
  }

  /// The planes that may have pixels in a cell.
  NearPlanes planes_near(int column, int row) const {
    NearPlanes near;
    for_around(column, row, reach, [&](std::uint8_t label) {
      if (label != 0) add_near(label, found_.planes[label - 1u].fit.plane, near);
    });
    return near;
  }

  /// How each label's plane meets this one: see RimPixels.
  const std::int32_t* bulges(std::uint8_t label) const { return &bulges_[label * labels_]; }

 private:
  /// 1: the smaller plane lies behind the larger one, -1: in front of it, 0: neither.
  std::int32_t bulge_of(std::size_t a, std::size_t b) const {
    constexpr double most_alike = 0.94;  // cosine
    const FramePlane *small = &found_.planes[a], *large = &found_.planes[b];
    if (small->fit.plane.normal.dot(large->fit.plane.normal) > most_alike) return 0;
    if (small->moments.points > large->moments.points) std::swap(small, large);
    const double off = large->fit.plane.distance(small->fit.centre);
    if (std::abs(off) < static_cast<double>(cells_.sigma(small->fit.centre.z()))) return 0;
    return off < 0 ? 1 : -1;
  }
  std::uint8_t plane(int column, int row) const {
    return plane_of_cell_[static_cast<std::size_t>(row * cells_.columns() + column)];
  }
  template <typename Visit>
  void for_around(int column, int row, int cells, Visit visit) const {
    for (int r = std::max(row - cells, 0); r <= std::min(row + cells, cells_.rows() - 1); ++r)
      for (int c = std::max(column - cells, 0); c <= std::min(column + cells, cells_.columns() - 1); ++c)
        visit(plane(c, r));
  }

  const CellMoments& cells_;
  const std::vector<std::uint8_t>& plane_of_cell_;
  const FramePlanes& found_;
  std::size_t labels_;                // 0 included
  std::vector<std::int32_t> bulges_;  // of each pair of them
};

cv::Rect cell_box(const CellMoments& cells, int column, int row) {
  return {column * cells.side(), row * cells.side(), cells.side(), cells.side()};
}

/// Where there is depth, all of a cell is the plane's own.
void label_measured(const cv::Mat& depth, const cv::Rect& box, std::uint8_t label, cv::Mat& labels) {
  for (int v = box.y; v < box.y + box.height; ++v) {
    const auto* measured = depth.ptr<std::uint16_t>(v) + box.x;
    std::transform(measured, measured + box.width, labels.ptr<std::uint8_t>(v) + box.x,
                   [label](std::uint16_t mm) { return mm != 0 ? label : std::uint8_t{0}; });
  }
}

}  // namespace

void follow_rims(const cv::Mat& depth, const CellMoments& cells, const std::vector<PlaneMoments>& moments,
                 const std::vector<std::uint8_t>& plane_of_cell, const FramePlaneSettings& settings,
                 FramePlanes& found) {
  found.labels = cv::Mat(depth.size(), CV_8UC1, cv::Scalar(0));
  const RimFollower follower(cells, plane_of_cell, found);
  RimPixels pixels(cells, settings.max_sigma);
  struct Rim {
    int column, row;
    NearPlanes near;
  };
  std::vector<Rim> rims;
  std::vector<PlaneMoments> sums(found.planes.size());
  for (int row = 0; row < cells.rows(); ++row)
    for (int column = 0; column < cells.columns(); ++column) {
      if (follower.is_inner(column, row)) {
        const auto cell = static_cast<std::size_t>(row * cells.columns() + column);
        sums[plane_of_cell[cell] - 1u].add(moments[cell]);
        label_measured(depth, cell_box(cells, column, row), plane_of_cell[cell], found.labels);
        continue;
      }
      Rim rim{column, row, follower.planes_near(column, row)};
      if (rim.near.empty()) continue;
      pixels.load(depth, column, row);
      for (const NearPlane& plane : rim.near)
        pixels.offer(plane, follower.bulges(plane.label), static_cast<float>(settings.max_distance_sigmas));
      pixels.write(found.labels, column, row);
      rims.push_back(std::move(rim));
    }
  const cv::Mat sharp = without_smoothed(found.labels, smoothed);
  for (const Rim& rim : rims) {
    pixels.load(depth, rim.column, rim.row);
    for (const NearPlane& plane : rim.near) {
      const PlaneMoments own = pixels.moments_of(plane, sharp, rim.column, rim.row, sure);
      if (own.points > 0) sums[plane.label - 1u].add(own.weighed(cells.sigma(own.sum.z() / own.points)));
    }
  }
  for (std::size_t k = 0; k < sums.size(); ++k) {
    FramePlane& plane = found.planes[k];
    if (sums[k].points < std::max(least_points, least_share * plane.moments.points)) continue;
    plane.moments = sums[k];
    plane.fit = sums[k].fit(Eigen::Vector3d::Zero());
  }
}

}  // namespace lcmslam
