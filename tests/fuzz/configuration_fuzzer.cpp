// Any text as a configuration, read as the processes read theirs. A part after the first NUL is used as an
// override (--set key=value).

#include <string>

#include <lcmslam/configuration/read_settings.hpp>
#include <lcmslam/settings/check.hpp>

namespace lcmslam {
namespace {

struct PartSettings {
  double radius = 0.5;
  int iterations = 10;
  std::uint64_t seed = 1;
  bool enabled = true;
  std::string name = "none", solver = "svd";
  std::vector<double> numbers = {1, 2};
  std::vector<std::string> names = {"a"};

  void describe(SettingsVisitor& s) {
    s.number("radius", radius, "m", {0, 10}, "of the part");
    s.number("iterations", iterations, "", {1, 1000}, "of the part");
    s.number("seed", seed, "", {0, 2147483647}, "of the part");
    s.flag("enabled", enabled, "whether it works");
    s.text("name", name, "of the part");
    s.numbers("numbers", numbers, "m", {-10, 10}, "of the part");
    s.texts("names", names, "of the part");
    s.choice("solver", solver, {"svd", "quaternion", "gauss_newton"}, "of the part");
    s.require(radius < 9 || enabled, "radius", "must be below 9 where it is off");
  }
};

struct Settings : PartSettings {
  PartSettings fine;
  void describe(SettingsVisitor& s) {
    PartSettings::describe(s);
    s.section("fine", fine, "second part");
  }
};

void read_all(const ConfigNode& config) {
  read_settings<PartSettings>(config);
  for (const char* name : {"camera", "icp", "fastslam"}) {
    const ConfigNode section = config.section(name);
    check(read_settings<Settings>(section), name);  // what was read is right
    section.numbers("translation", 3);
    section.text("frame");
    section.number("height", Range{0, 3});
  }
  for (const ConfigNode& item : config.sections("rooms")) read_settings<PartSettings>(item);
  for (const std::string& key : config.keys()) config.where(key);
  config.ignore("launch");
  config.finish();
}

/// Whatever reading stops at, the others are tried too.
template <class Function>
void refused_or_read(Function function) {
  try {
    function();
  } catch (const ConfigError&) {
  }
}

}  // namespace
}  // namespace lcmslam

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace lcmslam;
  const std::string input(reinterpret_cast<const char*>(data), size);
  const std::size_t nul = input.find('\0');
  refused_or_read([&] {
    ConfigNode config = ConfigNode::parse(input.substr(0, nul), "/no/such/folder/fuzzed.yaml");
    if (nul != std::string::npos) {
      const std::string text = input.substr(nul + 1);
      const std::size_t equals = text.find('=');
      refused_or_read([&] {
        config.set(text.substr(0, equals), equals == std::string::npos ? "" : text.substr(equals + 1));
      });
    }
    refused_or_read([&] { read_all(config); });
    refused_or_read([&] { read_settings<PartSettings>(config); });
    for (const std::string& key : config.keys()) {
      refused_or_read([&] { config.number(key); });
      refused_or_read([&] { config.get(key, true); });
      refused_or_read([&] { config.get(key, std::vector<double>()); });
      refused_or_read([&] { read_all(config.section(key)); });
      refused_or_read([&] { config.sections(key); });
    }
    refused_or_read([&] { config.finish(); });
  });
  return 0;
}
