#pragma once
// Settings that describe themselves: key, unit, default, range and one line of meaning stand beside each
// field, once. Reading from YAML (configuration/read_settings.hpp), the check at construction, `lcmslam
// config` and docs/CONFIGURATION.md all come from that description.
//
//   struct CloudFilterSettings {
//     double min_range = 0.3;
//     double max_range = 6.0;
//
//     void describe(SettingsVisitor& s) {
//       s.number("min_range", min_range, "m", {0, 1000}, "nearest distance from the camera that is used");
//       s.number("max_range", max_range, "m", {0, 1000}, "farthest distance from the camera that is used");
//       s.require(min_range <= max_range, "max_range", "must not be below min_range");
//     }
//   };
//
// A field without a line in describe() is no setting: its comment says who sets it.

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <string>
#include <type_traits>
#include <vector>

#include <lcmslam/settings/range.hpp>

namespace lcmslam {

/// A value of an enumeration and its name in configurations.
template <class E>
struct Choice {
  const char* name;
  E value;
};

/// The name of a value; empty when the table lacks it.
template <class E, std::size_t N>
const char* name_of(E value, const Choice<E> (&names)[N]) {
  for (const Choice<E>& choice : names)
    if (choice.value == value) return choice.name;
  return "";
}

/// What is said of a setting beside its value.
struct Setting {
  const char* key;
  const char* meaning;  ///< one line
  const char* unit = "";
  Range range = {};                       ///< of numbers
  bool whole = false;                     ///< numbers without a fraction
  std::vector<const char*> choices = {};  ///< the only values of a text or of the texts of a list; empty: any
  bool required = false;                  ///< there is no default that would do
};

/// Calls a struct's describe() with what shall be done to its fields.
class SettingsVisitor {
 public:
  virtual ~SettingsVisitor() = default;

  /// T: double, int or std::uint64_t (seeds; up to 2^53).
  template <class T>
  void number(const char* key, T& value, const char* unit, const Range& range, const char* meaning) {
    static_assert(std::is_same_v<T, double> || std::is_same_v<T, int> || std::is_same_v<T, std::uint64_t>);
    const auto before = static_cast<double>(value);
    const double after = on_number({key, meaning, unit, range, std::is_integral_v<T>}, before);
    // What was not changed keeps every bit.
    if (after != before) value = static_cast<T>(after);
  }
  void flag(const char* key, bool& value, const char* meaning) { value = on_flag({key, meaning}, value); }
  void text(const char* key, std::string& value, const char* meaning) {
    value = on_text({key, meaning}, value);
  }
  /// A text that must be given.
  void required(const char* key, std::string& value, const char* meaning) {
    Setting setting{key, meaning};
    setting.required = true;
    value = on_text(setting, value);
  }
  /// std::filesystem::path.
  template <class Path>
  void path(const char* key, Path& value, const char* meaning) {
    value = on_text({key, meaning}, value.string());
  }
  template <class Path>
  void required_path(const char* key, Path& value, const char* meaning) {
    std::string text = value.string();
    required(key, text, meaning);
    value = text;
  }
  void numbers(const char* key, std::vector<double>& values, const char* unit, const Range& range,
               const char* meaning) {
    values = on_numbers({key, meaning, unit, range}, values);
  }
  /// Any texts, or any of `choices`.
  void texts(const char* key, std::vector<std::string>& values, const char* meaning,
             std::vector<const char*> choices = {}) {
    values = on_texts({key, meaning, "", {}, false, std::move(choices)}, values);
  }
  /// One of several names.
  void choice(const char* key, std::string& value, std::initializer_list<const char*> choices,
              const char* meaning) {
    value = on_text({key, meaning, "", {}, false, choices}, value);
  }
  template <class E, std::size_t N>
  void choice(const char* key, E& value, const Choice<E> (&names)[N], const char* meaning) {
    std::vector<const char*> choices;
    for (const Choice<E>& choice : names) choices.push_back(choice.name);
    const std::string name =
        on_text({key, meaning, "", {}, false, std::move(choices)}, name_of(value, names));
    for (const Choice<E>& choice : names)
      if (name == choice.name) value = choice.value;
  }

  /// Settings below a key of their own.
  template <class S>
  void section(const char* key, S& settings, const char* meaning,
               void (S::*describe)(SettingsVisitor&) = &S::describe) {
    begin_section(key, meaning, true);
    (settings.*describe)(*this);
    end_section();
  }
  /// One of several sections of which another setting chooses one. The others may stand in a file and are not
  /// looked at.
  template <class S>
  void alternative(bool chosen, const char* key, S& settings, const char* meaning) {
    if (!begin_section(key, meaning, chosen)) return;
    settings.describe(*this);
    end_section();
  }

  /// What ranges cannot say. `key`, dotted from here, is what the error speaks of: "must be above min_range".
  virtual void require(bool condition, const char* key, const char* problem) = 0;

 protected:
  // Each is told the value and gives the one that holds from now on.
  virtual double on_number(const Setting& setting, double value) = 0;
  virtual bool on_flag(const Setting& setting, bool value) = 0;
  virtual std::string on_text(const Setting& setting, const std::string& value) = 0;
  virtual std::vector<double> on_numbers(const Setting& setting, const std::vector<double>& values) = 0;
  virtual std::vector<std::string> on_texts(const Setting& setting,
                                            const std::vector<std::string>& values) = 0;
  /// False: the section is passed over, and there is no end_section().
  virtual bool begin_section(const char* key, const char* meaning, bool chosen) = 0;
  virtual void end_section() = 0;
};

}  // namespace lcmslam
