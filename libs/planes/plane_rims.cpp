#include <lcmslam/planes/plane_rims.hpp>

#include <algorithm>
#include <cmath>

namespace lcmslam {
namespace {

constexpr int reach = 2;              // cells, from a plane to pixels that may be its own
constexpr float sure = 1;             // sigmas off the plane up to which pixels tell where it lies
constexpr double least_share = 0.25;  // of a plane's points that must be left for another fit

/// The planes that may have pixels in a cell.
struct NearPlanes {
  struct Plane {
    float x, y, z, offset;
    std::uint8_t label;
    PlaneMoments sure;  // of pixels that lie in it for sure, of weight 1
  };
  std::vector<Plane> planes;

  void add(std::uint8_t label, const PlaneEquation& plane) {
    for (const Plane& other : planes)
      if (other.label == label) return;
    const Eigen::Vector3f n = plane.normal.cast<float>();
    planes.push_back({n.x(), n.y(), n.z(), static_cast<float>(plane.offset), label, {}});
  }
};

class RimFollower {
 public:
  RimFollower(const cv::Mat& depth, const CellMoments& cells, const std::vector<std::uint8_t>& plane_of_cell,
              const FramePlaneSettings& settings, FramePlanes& found)
      : depth_(depth),
        cells_(cells),
        plane_of_cell_(plane_of_cell),
        gate_(static_cast<float>(settings.max_distance_sigmas)),
        max_sigma_(static_cast<float>(settings.max_sigma)),
        found_(found) {}

  /// Whether a cell and all around it are of the same plane.
  bool is_inner(int column, int row) const {
    const std::uint8_t own = plane(column, row);
    bool inner = own != 0;
    for_around(column, row, 1, [&](std::uint8_t other) { inner = inner && other == own; });
    return inner;
  }

  /// The planes that may have pixels in a cell.
  void find_near(int column, int row, NearPlanes& near) const {
    near.planes.clear();
    for_around(column, row, reach, [&](std::uint8_t label) {
      if (label != 0) near.add(label, found_.planes[label - 1u].fit.plane);
    });
  }

  void label_inner(int column, int row) {
    const std::uint8_t own = plane(column, row);
    for_rows(column, row, [&](int, int, const std::uint16_t* depth, std::uint8_t* label) {
      for (int i = 0; i < cells_.side(); ++i) label[i] = depth[i] != 0 ? own : std::uint8_t{0};
    });
  }

  /// The nearest plane for each pixel. The sure ones count for the planes.
  void label_rim(int column, int row, NearPlanes& near) {
    for_rows(column, row, [&](int v, int u, const std::uint16_t* depth, std::uint8_t* label) {
      for (int i = 0; i < cells_.side(); ++i) {
        const float sigma = cells_.sigma_of(depth[i]);
        if (!(sigma <= max_sigma_)) continue;
        const Eigen::Vector3f point = cells_.point(v, u + i, 0.001f * static_cast<float>(depth[i]));
        float best = gate_ * sigma;
        NearPlanes::Plane* own = nullptr;
        for (NearPlanes::Plane& p : near.planes) {
          const float off = std::abs(p.x * point.x() + p.y * point.y() + p.z * point.z() + p.offset);
          if (off >= best) continue;
          best = off;
          own = &p;
        }
        if (own == nullptr) continue;
        label[i] = own->label;
        if (best <= sure * sigma) own->sure.add(point.cast<double>());
      }
    });
  }

 private:
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
};

}  // namespace

void follow_rims(const cv::Mat& depth, const CellMoments& cells, const std::vector<PlaneMoments>& moments,
                 const std::vector<std::uint8_t>& plane_of_cell, const FramePlaneSettings& settings,
                 FramePlanes& found) {
  found.labels = cv::Mat(depth.size(), CV_8UC1, cv::Scalar(0));
  RimFollower follower(depth, cells, plane_of_cell, settings, found);
  std::vector<PlaneMoments> sums(found.planes.size());
  NearPlanes near;
  for (int row = 0; row < cells.rows(); ++row)
    for (int column = 0; column < cells.columns(); ++column) {
      if (follower.is_inner(column, row)) {
        const auto cell = static_cast<std::size_t>(row * cells.columns() + column);
        sums[plane_of_cell[cell] - 1u].add(moments[cell]);
        follower.label_inner(column, row);
        continue;
      }
      follower.find_near(column, row, near);
      if (near.planes.empty()) continue;
      follower.label_rim(column, row, near);
      for (const NearPlanes::Plane& p : near.planes)
        if (p.sure.points > 0)
          sums[p.label - 1u].add(p.sure.weighed(cells.sigma(p.sure.sum.z() / p.sure.points)));
    }
  for (std::size_t k = 0; k < sums.size(); ++k) {
    FramePlane& plane = found.planes[k];
    if (sums[k].points < least_share * plane.moments.points) continue;
    plane.moments = sums[k];
    plane.fit = sums[k].fit(Eigen::Vector3d::Zero());
  }
}

}  // namespace lcmslam
