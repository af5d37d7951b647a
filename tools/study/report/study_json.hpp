#pragma once
// What an experiment told, as report.json has it: numbers to six significant digits, null where not measured.

#include <nlohmann/json.hpp>

#include "tools/study/report/experiment.hpp"

namespace lcmslam {

/// "agrees", "agrees in part", "differs" or "beyond the thesis".
const char* words_for(Agreement agreement);

/// Pictures are named by their files alone. Throws std::invalid_argument where a series' x, y, low and high
/// or a heat map's rows and columns differ in length: the page could not draw them.
nlohmann::json experiment_json(const ExperimentResult& result);

/// Every number of it rounded as above.
nlohmann::json rounded(const nlohmann::json& value);

}  // namespace lcmslam
