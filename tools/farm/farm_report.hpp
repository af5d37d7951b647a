#pragma once
// A farm's results for people (a table, a page) and for the engines that run it (JUnit's XML).

#include <optional>
#include <string>
#include <vector>

#include "tools/farm/farm_comparison.hpp"

namespace lcmslam {

/// Plain text: a row a log, then how many passed and the median errors.
std::string farm_table(const std::vector<FarmResult>& results);
std::string comparison_text(const FarmComparison& comparison);

/// A page for the farm's folder: the rows in their order with each run's pictures, found by relative links.
std::string farm_page(const std::string& title, const std::vector<FarmResult>& results,
                      const std::optional<FarmComparison>& comparison);

/// A test suite with a case a log.
std::string junit_xml(const std::string& suite, const std::vector<FarmResult>& results);

}  // namespace lcmslam
