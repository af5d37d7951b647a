#include <lcmslam/calibration/self/marginal_covariance.hpp>

#include <ceres/ceres.h>
#include <Eigen/Cholesky>
#include <algorithm>
#include <map>

namespace lcmslam {
namespace {

int tangent_size(const ceres::Problem& problem, const std::vector<double*>& blocks) {
  int size = 0;
  for (double* block : blocks)
    if (!problem.IsParameterBlockConstant(block)) size += problem.ParameterBlockTangentSize(block);
  return size;
}

/// H += rows' rows, in the columns that the rows have.
void add_product(Eigen::MatrixXd& H, const std::vector<int>& columns, const Eigen::MatrixXd& block) {
  for (std::size_t i = 0; i < columns.size(); ++i)
    for (std::size_t k = 0; k < columns.size(); ++k)
      H(columns[i], columns[k]) += block(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k));
}

}  // namespace

Eigen::MatrixXd marginal_covariance(ceres::Problem& problem, const std::vector<double*>& wanted,
                                    const std::vector<double*>& others,
                                    const std::vector<double*>& landmarks) {
  ceres::Problem::EvaluateOptions options;
  options.num_threads = 1;
  for (const auto* blocks : {&wanted, &others, &landmarks})
    options.parameter_blocks.insert(options.parameter_blocks.end(), blocks->begin(), blocks->end());
  ceres::CRSMatrix J;
  problem.Evaluate(options, nullptr, nullptr, nullptr, &J);

  const int dense = tangent_size(problem, wanted) + tangent_size(problem, others);
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(dense, dense);
  std::vector<std::vector<int>> rows_of(landmarks.size() + 1);  // the last: of no landmark
  for (int row = 0; row < J.num_rows; ++row) {
    std::size_t of = landmarks.size();
    for (int k = J.rows[static_cast<std::size_t>(row)]; k < J.rows[static_cast<std::size_t>(row) + 1]; ++k)
      if (const int column = J.cols[static_cast<std::size_t>(k)]; column >= dense)
        of = static_cast<std::size_t>((column - dense) / 3);
    rows_of[of].push_back(row);
  }
  for (std::size_t landmark = 0; landmark < rows_of.size(); ++landmark) {
    std::map<int, int> place;  // of the dense columns that these rows have
    for (const int row : rows_of[landmark])
      for (int k = J.rows[static_cast<std::size_t>(row)]; k < J.rows[static_cast<std::size_t>(row) + 1]; ++k)
        if (J.cols[static_cast<std::size_t>(k)] < dense)
          place.emplace(J.cols[static_cast<std::size_t>(k)], 0);
    std::vector<int> columns;
    for (auto& [column, at] : place) at = static_cast<int>(columns.size()), columns.push_back(column);

    const auto rows = static_cast<Eigen::Index>(rows_of[landmark].size());
    Eigen::MatrixXd A = Eigen::MatrixXd::Zero(rows, static_cast<Eigen::Index>(columns.size()));
    Eigen::MatrixXd B = Eigen::MatrixXd::Zero(rows, 3);
    for (Eigen::Index i = 0; i < rows; ++i) {
      const auto row = static_cast<std::size_t>(rows_of[landmark][static_cast<std::size_t>(i)]);
      for (int k = J.rows[row]; k < J.rows[row + 1]; ++k) {
        const int column = J.cols[static_cast<std::size_t>(k)];
        const double value = J.values[static_cast<std::size_t>(k)];
        if (column < dense)
          A(i, place.at(column)) = value;
        else
          B(i, (column - dense) % 3) = value;
      }
    }
    Eigen::MatrixXd block = A.transpose() * A;
    if (landmark < landmarks.size() && rows > 0) {
      const Eigen::MatrixXd W = A.transpose() * B;
      // A landmark that two residuals alone fix: what they leave open costs nothing.
      const Eigen::Matrix3d V = B.transpose() * B + 1e-9 * Eigen::Matrix3d::Identity();
      block -= W * V.ldlt().solve(W.transpose());
    }
    add_product(H, columns, block);
  }
  const Eigen::MatrixXd inverse = H.ldlt().solve(Eigen::MatrixXd::Identity(dense, dense));
  const int size = tangent_size(problem, wanted);
  return inverse.topLeftCorner(size, size);
}

}  // namespace lcmslam
