#include "tools/study/report/result_parts.hpp"

#include <fmt/format.h>
#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "tools/study/measures.hpp"

namespace lcmslam {

Spread spread_of(const std::vector<double>& values) {
  std::vector<double> finite;
  std::copy_if(values.begin(), values.end(), std::back_inserter(finite),
               [](double v) { return std::isfinite(v); });
  if (finite.empty()) return {std::nan(""), std::nan(""), std::nan(""), 0, values.size()};
  const auto [low, high] = std::minmax_element(finite.begin(), finite.end());
  return {median(finite), *low, *high, finite.size(), values.size()};
}

double median_or_lost(std::vector<double> values) {
  constexpr double lost = std::numeric_limits<double>::infinity();
  if (values.empty()) return lost;
  for (double& value : values)
    if (!std::isfinite(value)) value = lost;
  return median(std::move(values));
}

std::string in_words(const Spread& s, double factor, const std::string& unit, int decimals) {
  if (!std::isfinite(s.median)) return "not measured";
  const std::string middle =
      fmt::format("{:.{}f}{}{}", factor * s.median, decimals, unit.empty() ? "" : " ", unit);
  std::string around = s.low == s.high ? ""
                                       : fmt::format("{:.{}f} to {:.{}f}", factor * s.low, decimals,
                                                     factor * s.high, decimals);
  if (s.measured < s.all)
    around += fmt::format("{}in {} of {}", around.empty() ? "" : ", ", s.measured, s.all);
  return around.empty() ? middle : middle + " (" + around + ")";
}

std::string in_words(const std::vector<double>& values, double factor, const std::string& unit,
                     int decimals) {
  return in_words(spread_of(values), factor, unit, decimals);
}

nlohmann::json number(double value) {
  if (!std::isfinite(value)) return nullptr;
  return std::stod(fmt::format("{:.6g}", value));
}

ChartSeries points_series(const std::string& name, const std::vector<Eigen::Vector2d>& points,
                          ChartSeries::Mark mark) {
  ChartSeries series;
  series.name = name;
  series.mark = mark;
  for (const Eigen::Vector2d& p : points) {
    series.x.push_back(p.x());
    series.y.push_back(p.y());
  }
  return series;
}

ChartSeries path_series(const std::string& name, const Trajectory& path,
                        const Eigen::Isometry3d& T_chart_path) {
  constexpr std::size_t most = 400;
  const std::size_t step = 1 + path.size() / most;
  std::vector<Eigen::Vector2d> points;
  for (std::size_t i = 0; i < path.size(); i += step)
    points.emplace_back((T_chart_path * path[i].T_world_body).translation().head<2>());
  return points_series(name, points, ChartSeries::Mark::line);
}

ChartSeries ellipse_series(const std::string& name, const Eigen::Vector2d& mean,
                           const Eigen::Matrix2d& covariance, double share) {
  constexpr int corners = 72;
  const Eigen::Matrix2d root = covariance.llt().matrixL();
  const double radius = std::sqrt(-2 * std::log(1 - share));  // chi square of two degrees of freedom
  std::vector<Eigen::Vector2d> outline;
  for (int i = 0; i <= corners; ++i) {
    const double angle = 2 * M_PI * i / corners;
    outline.emplace_back(mean + radius * root * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
  }
  return points_series(name, outline, ChartSeries::Mark::ellipse_outline);
}

ChartSeries distribution_series(const std::string& name, const std::vector<double>& ascending,
                                double factor) {
  constexpr int steps = 60;
  ChartSeries series;
  series.name = name;
  for (int i = 0; i <= steps && !ascending.empty(); ++i) {
    const double share = 0.99 * i / steps;  // the last percent would stretch the axis
    series.x.push_back(factor * quantile_of(ascending, share));
    series.y.push_back(100 * share);
  }
  return series;
}

ChartSeries spread_series(const std::string& name, const std::vector<double>& x,
                          const std::vector<std::vector<double>>& values, double factor) {
  ChartSeries series;
  series.name = name;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const Spread s = spread_of(values[i]);
    if (!std::isfinite(s.median)) continue;
    series.x.push_back(x[i]);
    series.y.push_back(factor * s.median);
    series.low.push_back(factor * s.low);
    series.high.push_back(factor * s.high);
  }
  return series;
}

double quantile_of(const std::vector<double>& ascending, double share) {
  if (ascending.empty()) return std::nan("");
  return ascending[static_cast<std::size_t>(share * static_cast<double>(ascending.size() - 1))];
}

}  // namespace lcmslam
