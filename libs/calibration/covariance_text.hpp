#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

namespace lcmslam {

/// How sure an estimate is, for the file beside its calibration: YAML with the values' names, their standard
/// deviations and the covariance, a row a value. `comment` says units and frame.
std::string covariance_text(const std::string& of, const std::vector<std::string>& values,
                            const Eigen::MatrixXd& covariance, const std::string& comment);

}  // namespace lcmslam
