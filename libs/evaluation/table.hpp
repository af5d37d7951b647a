#pragma once
// Aligned plain-text tables for reports.

#include <iosfwd>
#include <string>
#include <vector>

namespace lcmslam {

/// Columns as wide as their widest cell, two blanks between; the first column stands left, the others
/// right. Widths count UTF-8 code points.
class Table {
 public:
  explicit Table(std::vector<std::string> header) : header_(std::move(header)) {}

  /// Throws std::invalid_argument when the number of cells is not the header's.
  void add(std::vector<std::string> row);

  std::string text() const;

 private:
  std::vector<std::string> header_;
  std::vector<std::vector<std::string>> rows_;
};

std::ostream& operator<<(std::ostream& out, const Table& table);

/// A number with fixed decimals; "-" when it is not finite.
std::string fixed_number(double value, int decimals);

}  // namespace lcmslam
