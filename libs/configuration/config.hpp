#pragma once
// Strict YAML configuration. Every key that a reader does not ask for is an error that names the
// file, the line and the nearest valid key; so is a value of the wrong kind or out of range.
//
//   ConfigNode config = ConfigNode::load("config/modern.yaml");
//   const auto settings = read_settings<SurfSettings>(config.section("surf"));   // read_settings.hpp
//   config.finish();   // throws for keys that nobody asked for, here and in all sections

#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include <lcmslam/settings/range.hpp>

namespace lcmslam {

class ConfigError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A mapping of a YAML file. Copies share the record of which keys were asked for.
class ConfigNode {
 public:
  /// An empty mapping: every get() gives its default.
  ConfigNode();
  /// Throws ConfigError when the file is missing or is not a YAML mapping. Keys of the mapping
  /// `include: other.yaml` (path relative to this file) are merged under this file's own.
  static ConfigNode load(const std::filesystem::path& file);
  static ConfigNode parse(const std::string& text, const std::string& name = "<text>");

  bool has(const std::string& key) const;
  /// Keys of this mapping in the file's order (for mappings with free keys, e.g. process names).
  std::vector<std::string> keys() const;

  // Optional values: the default when the key is absent.
  double get(const std::string& key, double fallback, Range range = {}) const;
  int get(const std::string& key, int fallback, Range range = {}) const;
  bool get(const std::string& key, bool fallback) const;
  std::string get(const std::string& key, const std::string& fallback) const;
  std::string get(const std::string& key, const char* fallback) const;
  std::vector<double> get(const std::string& key, const std::vector<double>& fallback) const;
  std::vector<std::string> get(const std::string& key, const std::vector<std::string>& fallback) const;
  /// One of the named choices.
  std::string choice(const std::string& key, const std::string& fallback,
                     const std::vector<std::string>& choices) const;

  // Required values: ConfigError when the key is absent.
  double number(const std::string& key, Range range = {}) const;
  std::string text(const std::string& key) const;
  /// Exactly `size` numbers.
  std::vector<double> numbers(const std::string& key, std::size_t size) const;

  /// A mapping below this one; empty when absent.
  ConfigNode section(const std::string& key) const;
  /// The mappings of a sequence below this one; none when absent.
  std::vector<ConfigNode> sections(const std::string& key) const;

  /// Overrides or adds one value, key as "section.key", value as YAML text (`--set` of the tools).
  void set(const std::string& dotted_key, const std::string& value);

  /// Accepts every key below without reading it (for parts that another process reads).
  void ignore(const std::string& key) const;

  /// Throws ConfigError naming the first key, here or in a section that was asked for, that nobody read.
  void finish() const;

  /// Folder of the file that says this key, or this mapping: what a path in it is relative to. Empty, the
  /// current folder, for what set() says.
  std::filesystem::path folder(const std::string& key = "") const;
  /// "file:line" of this mapping or of one of its keys, for messages of the caller.
  std::string where(const std::string& key = "") const;
  /// ConfigError with where(key) in front.
  [[noreturn]] void fail(const std::string& key, const std::string& problem) const;

 private:
  struct Data;
  explicit ConfigNode(std::shared_ptr<Data> data);
  std::shared_ptr<Data> data_;
};

}  // namespace lcmslam
