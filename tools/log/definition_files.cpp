#include "tools/log/definition_files.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "tools/log/message_facts.hpp"

namespace lcmslam {
namespace {

std::string text_of(const std::string& file) {
  std::ifstream in(file);
  std::ostringstream text;
  text << in.rdbuf();
  if (!in) throw std::runtime_error(file + ": cannot be read");
  return text.str();
}

/// The .lcm files of a folder and below, by name.
std::vector<std::string> definition_files_in(const std::string& folder) {
  std::vector<std::string> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
    if (entry.is_regular_file() && entry.path().extension() == ".lcm") files.push_back(entry.path().string());
  if (files.empty()) throw std::runtime_error(folder + ": has no .lcm file in it or below");
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace

std::vector<const MessageType*> read_definitions(const std::vector<std::string>& paths) {
  std::vector<std::string> texts;
  std::string named;
  for (const std::string& path : paths) {
    named += " " + path;
    if (!std::filesystem::is_directory(path)) {
      texts.push_back(text_of(path));
      continue;
    }
    for (const std::string& file : definition_files_in(path)) texts.push_back(text_of(file));
  }
  try {
    return parse_definitions(texts);
  } catch (const std::invalid_argument& error) {
    throw std::runtime_error("--definitions" + named + ": " + error.what());
  }
}

const MessageType* KnownTypes::find(std::uint64_t fingerprint) const {
  for (const MessageType* type : more_)
    if (type->fingerprint == fingerprint) return type;
  return MessageType::find(fingerprint);
}

const MessageType* KnownTypes::of(const std::uint8_t* data, std::size_t size) const {
  const auto found = fingerprint(data, size);
  return found ? find(*found) : nullptr;
}

}  // namespace lcmslam
