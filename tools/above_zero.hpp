#pragma once
#include <CLI/CLI.hpp>
#include <cmath>

namespace lcmslam {

/// In the place of CLI::PositiveNumber, which tells the largest double in 310 digits.
inline CLI::Validator above_zero() {
  const auto problem_of = [](const std::string& text) {
    double number = 0;
    const bool good = CLI::detail::lexical_cast(text, number) && number > 0 && std::isfinite(number);
    return good ? std::string() : text + " is no number above 0";
  };
  return CLI::Validator(problem_of, "POSITIVE");
}

}  // namespace lcmslam
