#pragma once
// What is done with described settings besides reading them: checked at construction, listed in tables.
//
//   Surf::Surf(const SurfSettings& settings) : settings_(settings) { check(settings_, "surf"); }

#include <lcmslam/settings/settings.hpp>

namespace lcmslam {

/// A setting as tables show it.
struct SettingEntry {
  std::string path;   ///< dotted key
  std::string value;  ///< as YAML text
  std::string unit;   ///< empty: a number of things, a ratio, or no number
  std::string
      kind;     ///< "number", "whole number", "true or false", "text", "list of numbers", "list of texts"
  Range range;  ///< of numbers
  std::vector<std::string> choices;
  std::string meaning;
  bool required = false;
};

/// Visits without changing: what list_settings() gives.
class SettingsLister : public SettingsVisitor {
 public:
  std::vector<SettingEntry> entries;
  void require(bool, const char*, const char*) override {}

 protected:
  double on_number(const Setting& setting, double value) override;
  bool on_flag(const Setting& setting, bool value) override;
  std::string on_text(const Setting& setting, const std::string& value) override;
  std::vector<double> on_numbers(const Setting& setting, const std::vector<double>& values) override;
  std::vector<std::string> on_texts(const Setting& setting, const std::vector<std::string>& values) override;
  bool begin_section(const char* key, const char* meaning, bool chosen) override;
  void end_section() override;

 private:
  void add(const Setting& setting, const char* kind, std::string value);
  std::vector<std::string> prefixes_;  // of the sections that are open, each with its dot
};

/// Visits without changing and remembers the first value that is wrong.
class SettingsCheck : public SettingsVisitor {
 public:
  bool failed() const { return !problem_.empty(); }
  /// Throws std::invalid_argument with the value, which stands in `entries`.
  [[noreturn]] void fail(const char* what, const std::vector<SettingEntry>& entries) const;
  void require(bool condition, const char* key, const char* problem) override;

 protected:
  double on_number(const Setting& setting, double value) override;
  bool on_flag(const Setting&, bool value) override { return value; }
  std::string on_text(const Setting& setting, const std::string& value) override;
  std::vector<double> on_numbers(const Setting& setting, const std::vector<double>& values) override;
  std::vector<std::string> on_texts(const Setting& setting, const std::vector<std::string>& values) override;
  bool begin_section(const char* key, const char* meaning, bool chosen) override;
  void end_section() override { sections_.pop_back(); }

 private:
  void remember(const char* key, std::string problem);
  std::vector<const char*> sections_;
  std::string path_, problem_;
};

/// Every setting with its value (of S{}: its default), in the order of the descriptions.
template <class S>
std::vector<SettingEntry> list_settings(S settings, void (S::*describe)(SettingsVisitor&) = &S::describe) {
  SettingsLister lister;
  (settings.*describe)(lister);
  return std::move(lister.entries);
}

/// Throws std::invalid_argument that names the dotted key, its value with the unit, and what would be right.
/// `what` stands in front: "surf".
template <class S>
void check(const S& settings, const char* what = "", void (S::*describe)(SettingsVisitor&) = &S::describe) {
  S copy = settings;
  SettingsCheck visitor;
  (copy.*describe)(visitor);
  if (visitor.failed()) visitor.fail(what, list_settings(copy, describe));
}

/// "a number from 0 to 1 (m)", "one of 'a', 'b'", ...: what a value of this setting must be.
std::string allowed(const SettingEntry& entry);
/// "one of 'a', 'b'".
std::string one_of(const std::vector<std::string>& choices);

/// The shortest text that is read back as the same number.
std::string number_text(double number);

}  // namespace lcmslam
