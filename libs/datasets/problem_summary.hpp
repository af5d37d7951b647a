#pragma once
#include <string>
#include <vector>

namespace lcmslam {

/// A line for each kind of problem, in the order in which they first came, with its count: "FILE: is
/// missing", or "200 times, first FILE: is missing". Problems ("FILE: reason") are of one kind when their
/// reasons are alike but for numbers.
std::vector<std::string> summarise_problems(const std::vector<std::string>& problems);

}  // namespace lcmslam
