#include <lcmslam/registration/selection.hpp>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>

#include <lcmslam/geometry/random.hpp>
#include <lcmslam/geometry/transform.hpp>

namespace lcmslam {
namespace {

using Indices = std::vector<std::size_t>;

// Every k-th point, k a fraction: exactly `count` of them.
void keep_uniform(Indices& indices, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) indices[i] = indices[i * indices.size() / count];
  indices.resize(count);
}

// The first `count` places of a Fisher-Yates shuffle.
void shuffle(Indices& indices, std::size_t count, Random& random) {
  for (std::size_t i = 0; i < count; ++i)
    std::swap(indices[i], indices[i + static_cast<std::size_t>(random.below(indices.size() - i))]);
}

void keep_random(Indices& indices, std::size_t count, Random& random) {
  shuffle(indices, count, random);
  indices.resize(count);
}

// Six faces of a cube around the normals, 4 x 4 cells each.
std::size_t direction_cell(const Eigen::Vector3f& normal) {
  Eigen::Index axis = 0;
  const float largest = normal.cwiseAbs().maxCoeff(&axis);
  const auto cell = [&](Eigen::Index other) {
    return static_cast<std::size_t>(std::clamp(2 * (normal((axis + other) % 3) / largest + 1), 0.0f, 3.0f));
  };
  const std::size_t face = 2 * static_cast<std::size_t>(axis) + (normal(axis) < 0 ? 1 : 0);
  return 16 * face + 4 * cell(1) + cell(2);
}

// One point of each direction in turn, until there are enough.
void keep_normal_space(const Cloud& source, Indices& indices, std::size_t count, Random& random) {
  std::array<Indices, 96> cells;
  shuffle(indices, indices.size(), random);
  for (const std::size_t i : indices) cells[direction_cell(source.normals[i])].push_back(i);
  indices.clear();
  for (std::size_t round = 0; indices.size() < count; ++round)
    for (const Indices& cell : cells)
      if (round < cell.size() && indices.size() < count) indices.push_back(cell[round]);
}

// Each point constrains the motion along its (p x n, n). Every eigenvector of their covariance has a list of
// the points by how much they constrain it; the least constrained one so far is served next.
void keep_stable(const Cloud& source, Indices& indices, std::size_t count, Random& random) {
  shuffle(indices, indices.size(), random);  // so that equals are spread over the cloud
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const std::size_t i : indices) mean += source.points[i].cast<double>();
  mean /= static_cast<double>(indices.size());
  double spread = 0;
  for (const std::size_t i : indices) spread += (source.points[i].cast<double>() - mean).norm();
  spread = std::max(spread / static_cast<double>(indices.size()), 1e-6);

  std::vector<Vector6d> constraints;
  Matrix6d covariance = Matrix6d::Zero();
  for (const std::size_t i : indices) {
    const Eigen::Vector3d n = source.normals[i].cast<double>();
    Vector6d c;
    c << n, ((source.points[i].cast<double>() - mean) / spread).cross(n);
    constraints.push_back(c);
    covariance.noalias() += c * c.transpose();
  }
  const Matrix6d directions = Eigen::SelfAdjointEigenSolver<Matrix6d>(covariance).eigenvectors();

  std::vector<Vector6d> shares;
  for (const Vector6d& c : constraints) shares.push_back((directions.transpose() * c).cwiseAbs2());
  std::array<Indices, 6> lists;
  for (int k = 0; k < 6; ++k) {
    Indices& list = lists[static_cast<std::size_t>(k)];
    for (std::size_t i = 0; i < indices.size(); ++i) list.push_back(i);
    std::stable_sort(list.begin(), list.end(),
                     [&](std::size_t a, std::size_t b) { return shares[a](k) > shares[b](k); });
  }
  std::vector<bool> taken(indices.size(), false);
  std::array<std::size_t, 6> next{};
  Vector6d constrained = Vector6d::Zero();
  Indices kept;
  while (kept.size() < count) {
    Eigen::Index weakest = 0;
    constrained.minCoeff(&weakest);
    const auto k = static_cast<std::size_t>(weakest);
    while (taken[lists[k][next[k]]]) ++next[k];
    const std::size_t i = lists[k][next[k]];
    taken[i] = true;
    constrained += shares[i];
    kept.push_back(indices[i]);
  }
  indices = kept;
}

bool needs_normals(SelectionKind kind) {
  return kind == SelectionKind::normal_space || kind == SelectionKind::stable;
}

}  // namespace

std::vector<std::size_t> select_points(const Cloud& source, const RegistrationSettings& settings) {
  Indices finite, with_normal;
  finite.reserve(source.size());
  for (std::size_t i = 0; i < source.size(); ++i) {
    if (!source.points[i].allFinite()) continue;
    finite.push_back(i);
    if (needs_normals(settings.selection) && source.has_normals() && source.normals[i].allFinite())
      with_normal.push_back(i);
  }
  const bool by_normals = !with_normal.empty();
  Indices& indices = by_normals ? with_normal : finite;
  const auto count = static_cast<std::size_t>(std::max(settings.selected_points, 0));
  if (settings.selection == SelectionKind::all || indices.size() <= count) return indices;

  Random random(settings.seed);
  if (settings.selection == SelectionKind::uniform)
    keep_uniform(indices, count);
  else if (by_normals && settings.selection == SelectionKind::normal_space)
    keep_normal_space(source, indices, count, random);
  else if (by_normals && settings.selection == SelectionKind::stable)
    keep_stable(source, indices, count, random);
  else
    keep_random(indices, count, random);
  std::sort(indices.begin(), indices.end());
  return indices;
}

}  // namespace lcmslam
