#include "tools/calibrate/range_report.hpp"

#include <fmt/format.h>

#include "tools/calibrate/units.hpp"

namespace lcmslam {

std::string range_report(const RangeErrorFit& fit) {
  const auto sigma = [&](int i) { return std::sqrt(fit.covariance(i, i)); };
  std::string text =
      fmt::format("  ranges           {:.2f} to {:.2f} m; off by {:.1f} mm RMS, {:.1f} mm when corrected\n",
                  fit.nearest, fit.farthest, mm_per_m * fit.rms_before, mm_per_m * fit.rms_after);
  text += fmt::format("  offset           {:.1f} +- {:.1f} mm\n", mm_per_m * fit.error.offset,
                      mm_per_m * sigma(0));
  if (fit.error.wiggle != 0)
    text += fmt::format("  wiggle           {:.1f} +- {:.1f} mm, period {:.2f} +- {:.2f} m\n",
                        mm_per_m * fit.error.wiggle, mm_per_m * sigma(2), fit.error.period, sigma(3));
  text += fmt::format("  apparent scale   {:+.2f} %{}\n", 100 * fit.apparent_scale,
                      fit.error.scale == 0 ? " (the focal length's error, by all likelihood: left out)" : "");
  for (const std::string& note : fit.notes) text += "  note: " + note + "\n";
  return text;
}

}  // namespace lcmslam
