#include <lcmslam/calibration/covariance_text.hpp>

#include <cmath>
#include <iomanip>
#include <sstream>
#include <stdexcept>

namespace lcmslam {

std::string covariance_text(const std::string& of, const std::vector<std::string>& values,
                            const Eigen::MatrixXd& covariance, const std::string& comment) {
  const auto n = static_cast<Eigen::Index>(values.size());
  if (covariance.rows() != n || covariance.cols() != n)
    throw std::invalid_argument("a covariance of " + std::to_string(covariance.rows()) + " values has " +
                                std::to_string(n) + " names");
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text << std::setprecision(8) << "# " << comment << "\nof: " << of << "\nvalues: [";
  for (Eigen::Index i = 0; i < n; ++i) text << (i > 0 ? ", " : "") << values[static_cast<std::size_t>(i)];
  text << "]\nsigma: [";
  for (Eigen::Index i = 0; i < n; ++i) text << (i > 0 ? ", " : "") << std::sqrt(covariance(i, i));
  text << "]\ncovariance:\n";
  for (Eigen::Index row = 0; row < n; ++row) {
    text << "  - [";
    for (Eigen::Index column = 0; column < n; ++column)
      text << (column > 0 ? ", " : "") << covariance(row, column);
    text << "]\n";
  }
  return text.str();
}

}  // namespace lcmslam
