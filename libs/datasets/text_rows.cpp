#include <lcmslam/datasets/text_rows.hpp>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include <lcmslam/datasets/dataset.hpp>

namespace lcmslam {
namespace {

std::optional<double> parse_number(const std::string& word) {
  std::istringstream stream(word);
  stream.imbue(std::locale::classic());
  double value = 0;
  stream >> value;
  if (stream.fail() || stream.peek() != std::istringstream::traits_type::eof() || !std::isfinite(value))
    return std::nullopt;
  return value;
}

}  // namespace

std::vector<TextRow> read_rows(const std::filesystem::path& file, std::vector<std::string>* comments) {
  std::ifstream stream(file);
  if (!stream || std::filesystem::is_directory(file))
    throw DatasetError(file.string() + ": cannot be opened for reading");
  std::vector<TextRow> rows;
  std::string line;
  for (int number = 1; std::getline(stream, line); ++number) {
    for (char& c : line)
      if (c == ',' || c == '\t' || c == '\r') c = ' ';
    std::istringstream words(line);
    TextRow row{number, {}};
    for (std::string word; words >> word;) row.words.push_back(word);
    if (row.words.empty()) continue;
    if (row.words[0][0] != '#')
      rows.push_back(std::move(row));
    else if (comments)
      comments->push_back(line);
  }
  return rows;
}

std::optional<std::vector<double>> row_numbers(const TextRow& row, std::size_t first, std::size_t count) {
  if (row.words.size() != first + count) return std::nullopt;
  std::vector<double> numbers;
  for (std::size_t i = first; i < row.words.size(); ++i) {
    const auto value = parse_number(row.words[i]);
    if (!value) return std::nullopt;
    numbers.push_back(*value);
  }
  return numbers;
}

std::optional<Utime> parse_stamp(const std::string& word) {
  const auto seconds = parse_number(word);
  if (!seconds || *seconds < 0 || *seconds > 9e9) return std::nullopt;
  return std::llround(*seconds * 1e6);  // a double resolves 0.24 us at today's stamps
}

std::string at_line(const std::filesystem::path& file, int line, const std::string& problem) {
  return file.string() + ":" + std::to_string(line) + ": " + problem;
}

}  // namespace lcmslam
