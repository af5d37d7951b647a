#pragma once
// Text files of rows, read so that one bad row is reported and the others are kept.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <lcmslam/geometry/transform.hpp>

namespace lcmslam {

struct TextRow {
  int line = 0;  ///< from 1
  std::vector<std::string> words;
};

/// Rows of words separated by blanks, tabs or commas; empty lines and comments (#) are left out, but
/// comments go to `comments` where given. Throws DatasetError when the file cannot be read.
std::vector<TextRow> read_rows(const std::filesystem::path& file,
                               std::vector<std::string>* comments = nullptr);

/// All words from `first` on as finite numbers, exactly `count` of them; nothing otherwise.
std::optional<std::vector<double>> row_numbers(const TextRow& row, std::size_t first, std::size_t count);

/// A stamp in seconds as microseconds; nothing unless it is a number from 0 to 9e9 (year 2255).
std::optional<Utime> parse_stamp(const std::string& word);

/// "file:line: problem".
std::string at_line(const std::filesystem::path& file, int line, const std::string& problem);

}  // namespace lcmslam
