#pragma once
// What experiments are told with: spreads over seeds, words with numbers, and the parts of charts.

#include <Eigen/Core>
#include <string>
#include <vector>

#include <lcmslam/evaluation/trajectory.hpp>
#include "tools/study/report/experiment.hpp"

namespace lcmslam {

/// Median, least and greatest of the finite values; NaN without any.
struct Spread {
  double median = 0, low = 0, high = 0;
  std::size_t measured = 0, all = 0;  ///< finite values, and those that were not, too
};
Spread spread_of(const std::vector<double>& values);

/// The median where what is not finite, as the error of who is lost, is worse than all that is: infinite
/// where most are, and without any value.
double median_or_lost(std::vector<double> values);

/// "1.2 cm (0.9 to 1.6)": the median, and the range where there are several seeds; "(0.9 to 1.6, in 2 of 5)"
/// where the others were not measured. `factor`: 100 for cm.
std::string in_words(const Spread& spread, double factor, const std::string& unit, int decimals = 1);
std::string in_words(const std::vector<double>& values, double factor, const std::string& unit,
                     int decimals = 1);

/// A number as JSON: null where it was not measured, rounded to six significant digits.
nlohmann::json number(double value);

ChartSeries points_series(const std::string& name, const std::vector<Eigen::Vector2d>& points,
                          ChartSeries::Mark mark = ChartSeries::Mark::dots);
/// The path from above.
ChartSeries path_series(const std::string& name, const Trajectory& path,
                        const Eigen::Isometry3d& T_chart_path = Eigen::Isometry3d::Identity());
/// Outline of a two-dimensional Gaussian that holds `share` of it, 0.95.
ChartSeries ellipse_series(const std::string& name, const Eigen::Vector2d& mean,
                           const Eigen::Matrix2d& covariance, double share = 0.95);
/// Share of the values (ascending) below each of them, at most 60 steps. x by `factor`.
ChartSeries distribution_series(const std::string& name, const std::vector<double>& ascending, double factor);
/// One point for each x with the spread of its values.
ChartSeries spread_series(const std::string& name, const std::vector<double>& x,
                          const std::vector<std::vector<double>>& values, double factor);

double quantile_of(const std::vector<double>& ascending, double share);

}  // namespace lcmslam
