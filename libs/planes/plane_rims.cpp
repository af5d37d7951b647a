#include <lcmslam/planes/plane_rims.hpp>

#include <algorithm>
#include <cmath>

namespace lcmslam {
namespace {

constexpr int reach = 2;     // cells, from a plane to pixels that may be its own
constexpr float sure = 1;    // sigmas off the plane up to which pixels tell where it lies
constexpr int smoothed = 2;  // pixels: what BilateralFilter takes means over
constexpr double least_points = 10;
constexpr double least_share = 0.05;  // of a plane's points that must be left for another fit

/// A plane that may have pixels in a cell.
struct NearPlane {
  float x, y, z, offset;
  std::uint8_t label;
  PlaneMoments sure;  // of pixels that lie in it for sure, of weight 1

  float distance(const Eigen::Vector3f& point) const {
    return x * point.x() + y * point.y() + z * point.z() + offset;
  }
  /// Where it is met along the ray of a point that lies near it, as a share of that point's depth.
  float along(const Eigen::Vector3f& point) const {
    const float off = distance(point);
    return offset / (offset - off);
  }
};
using NearPlanes = std::vector<NearPlane>;

void add_near(std::uint8_t label, const PlaneEquation& plane, NearPlanes& near) {
  for (const NearPlane& other : near)
    if (other.label == label) return;
  const Eigen::Vector3f n = plane.normal.cast<float>();
  near.push_back({n.x(), n.y(), n.z(), static_cast<float>(plane.offset), label, {}});
}

class RimFollower {
 public:
  RimFollower(const cv::Mat& depth, const CellMoments& cells, const std::vector<std::uint8_t>& plane_of_cell,
              const FramePlaneSettings& settings, FramePlanes& found)
      : depth_(depth),
        cells_(cells),
        plane_of_cell_(plane_of_cell),
        gate_(static_cast<float>(settings.max_distance_sigmas)),
        max_sigma_(static_cast<float>(settings.max_sigma)),
        found_(found),
        bulges_(found.planes.size() * found.planes.size()) {
    for (std::size_t a = 0; a < found.planes.size(); ++a)
      for (std::size_t b = 0; b < found.planes.size(); ++b)
        bulges_[a * found.planes.size() + b] = bulge_of(a, b);
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

  void label_inner(int column, int row) {
    const std::uint8_t own = plane(column, row);
    for_rows(column, row, [&](int, int, const std::uint16_t* depth, std::uint8_t* label) {
      for (int i = 0; i < cells_.side(); ++i) label[i] = depth[i] != 0 ? own : std::uint8_t{0};
    });
  }

  /// Each pixel goes to a plane, and counts for it where it lies in it for sure.
  void label_rim(int column, int row, NearPlanes& near) {
    for_rows(column, row, [&](int v, int u, const std::uint16_t* depth, std::uint8_t* label) {
      for (int i = 0; i < cells_.side(); ++i) {
        const float sigma = cells_.sigma_of(depth[i]);
        if (!(sigma <= max_sigma_)) continue;
        const Eigen::Vector3f point = cells_.point(v, u + i, 0.001f * static_cast<float>(depth[i]));
        NearPlane* own = nullptr;
        for (NearPlane& p : near)
          if (std::abs(p.distance(point)) < gate_ * sigma && (own == nullptr || is_before(p, *own, point)))
            own = &p;
        if (own == nullptr) continue;
        label[i] = own->label;
        if (std::abs(own->distance(point)) <= sure * sigma) own->sure.add(point.cast<double>());
      }
    });
  }

  /// Once all labels are there: pixels that a neighbour of another plane was smoothed with do not count.
  void leave_out_smoothed(int column, int row, NearPlanes& near) const {
    if (near.size() < 2 || !shows_two_planes(column, row)) return;
    for (NearPlane& p : near) p.sure = {};
    for_rows(column, row, [&](int v, int u, const std::uint16_t* depth, const std::uint8_t* label) {
      for (int i = 0; i < cells_.side(); ++i) {
        if (label[i] == 0 || is_bent(v, u + i)) continue;
        const Eigen::Vector3f point = cells_.point(v, u + i, 0.001f * static_cast<float>(depth[i]));
        for (NearPlane& p : near)
          if (p.label == label[i] && std::abs(p.distance(point)) <= sure * cells_.sigma_of(depth[i]))
            p.sure.add(point.cast<double>());
      }
    });
  }

 private:
  /// Which of two planes near a point its pixel shows, by where they meet and not by what noise makes of the
  /// point: of two that bulge (a box's sides) a ray meets the farther one last and enters there, of two that
  /// form a corner the nearer one. Where they are almost one, or do not tell, the nearer to the point.
  bool is_before(const NearPlane& a, const NearPlane& b, const Eigen::Vector3f& point) const {
    const float along_a = a.along(point), along_b = b.along(point);
    const int bulge = bulges_[(a.label - 1u) * found_.planes.size() + (b.label - 1u)];
    if (bulge == 0) return std::abs(along_a - 1) < std::abs(along_b - 1);
    return bulge > 0 ? along_a > along_b : along_a < along_b;
  }
  /// 1: the smaller plane lies behind the larger one, -1: in front of it, 0: neither.
  std::int8_t bulge_of(std::size_t a, std::size_t b) const {
    constexpr double most_alike = 0.94;  // cosine
    const FramePlane *small = &found_.planes[a], *large = &found_.planes[b];
    if (small->fit.plane.normal.dot(large->fit.plane.normal) > most_alike) return 0;
    if (small->moments.points > large->moments.points) std::swap(small, large);
    const double off = large->fit.plane.distance(small->fit.centre);
    if (std::abs(off) < static_cast<double>(cells_.sigma(small->fit.centre.z()))) return 0;
    return off < 0 ? 1 : -1;
  }
  /// Whether a cell with what smoothing brings into it has pixels of two planes.
  bool shows_two_planes(int column, int row) const {
    const int side = cells_.side(), left = std::max(column * side - smoothed, 0),
              right = std::min((column + 1) * side + smoothed, depth_.cols);
    int lowest = 256, highest = 0;
    for (int v = std::max(row * side - smoothed, 0); v < std::min((row + 1) * side + smoothed, depth_.rows);
         ++v) {
      const auto* label = found_.labels.ptr<std::uint8_t>(v);
      for (int u = left; u < right; ++u) {
        lowest = std::min(lowest, label[u] == 0 ? 256 : static_cast<int>(label[u]));
        highest = std::max(highest, static_cast<int>(label[u]));
      }
    }
    return lowest < highest;
  }
  /// Whether a pixel of another plane is within what smoothing reaches.
  bool is_bent(int v, int u) const {
    const auto* row = found_.labels.ptr<std::uint8_t>(v);
    const std::uint8_t own = row[u];
    const auto is_other = [own](std::uint8_t label) { return label != 0 && label != own; };
    for (int k = 1; k <= smoothed; ++k) {
      const int up = std::max(v - k, 0), down = std::min(v + k, depth_.rows - 1);
      if (is_other(row[std::max(u - k, 0)]) || is_other(row[std::min(u + k, depth_.cols - 1)]) ||
          is_other(found_.labels.ptr<std::uint8_t>(up)[u]) ||
          is_other(found_.labels.ptr<std::uint8_t>(down)[u]))
        return true;
    }
    return false;
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
  /// The rows of a cell: its first pixel in each, and depths and labels from there on.
  template <typename Visit>
  void for_rows(int column, int row, Visit visit) const {
    const int side = cells_.side(), u = column * side;
    for (int v = row * side; v < (row + 1) * side; ++v)
      visit(v, u, depth_.ptr<std::uint16_t>(v) + u, found_.labels.ptr<std::uint8_t>(v) + u);
  }

  const cv::Mat& depth_;
  const CellMoments& cells_;
  const std::vector<std::uint8_t>& plane_of_cell_;
  float gate_, max_sigma_;
  FramePlanes& found_;
  std::vector<std::int8_t> bulges_;  // of each pair of planes
};

}  // namespace

void follow_rims(const cv::Mat& depth, const CellMoments& cells, const std::vector<PlaneMoments>& moments,
                 const std::vector<std::uint8_t>& plane_of_cell, const FramePlaneSettings& settings,
                 FramePlanes& found) {
  found.labels = cv::Mat(depth.size(), CV_8UC1, cv::Scalar(0));
  RimFollower follower(depth, cells, plane_of_cell, settings, found);
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
        follower.label_inner(column, row);
        continue;
      }
      Rim rim{column, row, follower.planes_near(column, row)};
      if (rim.near.empty()) continue;
      follower.label_rim(column, row, rim.near);
      rims.push_back(std::move(rim));
    }
  for (Rim& rim : rims) {
    follower.leave_out_smoothed(rim.column, rim.row, rim.near);
    for (const NearPlane& p : rim.near)
      if (p.sure.points > 0)
        sums[p.label - 1u].add(p.sure.weighed(cells.sigma(p.sure.sum.z() / p.sure.points)));
  }
  for (std::size_t k = 0; k < sums.size(); ++k) {
    FramePlane& plane = found.planes[k];
    if (sums[k].points < std::max(least_points, least_share * plane.moments.points)) continue;
    plane.moments = sums[k];
    plane.fit = sums[k].fit(Eigen::Vector3d::Zero());
  }
}

}  // namespace lcmslam
