#include "tools/calibrate/calibration_output.hpp"

#include <fmt/format.h>
#include <iostream>

#include <lcmslam/files/atomic_file.hpp>
#include <lcmslam/imaging/io/calibration_file.hpp>
#include <lcmslam/imaging/io/calibration_text.hpp>
#include "tools/output_file.hpp"

namespace lcmslam {
namespace fs = std::filesystem;

void CalibrationOutput::add_to(CLI::App& app, const char* what) {
  app.add_option("-o,--output", file, what)->required();
  app.add_option("--into", into, "calibration (YAML) whose other values stay; default: the log's own")
      ->check(CLI::ExistingFile);
  app.add_option("--sensor", sensor, "name of the camera head");
  app.add_flag("--force", force, "overwrite the output if it exists");
  app.add_flag("--accept", accept, "write it although the set is refused");
}

void CalibrationOutput::check() const {
  check_output_file(file, force);
  check_output_file(covariance_file(), force);
}

std::optional<RgbdCalibration> CalibrationOutput::base(const std::optional<RgbdCalibration>& of_input) const {
  if (!into.empty()) return load_calibration(into);
  return of_input;
}

fs::path CalibrationOutput::covariance_file() const {
  const fs::path path(file);
  return path.parent_path() / (path.stem().string() + "_covariance.yaml");
}

void CalibrationOutput::write(RgbdCalibration calibration, const std::string& comment,
                              const std::string& covariance) const {
  if (!sensor.empty()) calibration.sensor = sensor;
  calibration.check();
  write_text(calibration_text(calibration, comment), covariance);
}

void CalibrationOutput::write_text(const std::string& text, const std::string& covariance) const {
  write_atomically(fs::path(file), text);
  write_atomically(covariance_file(), covariance);
  std::cout << fmt::format("{}: written; {}: how sure it is\n", file, covariance_file().string());
}

void advise(const std::vector<std::string>& wanted) {
  for (const std::string& advice : wanted) std::cout << "  note: " << advice << "\n";
}

int refuse(const std::vector<std::string>& missing, bool accept) {
  for (const std::string& reason : missing) std::cout << "  missing: " << reason << "\n";
  if (missing.empty()) return 0;
  std::cout << (accept ? "Written all the same, as --accept asks.\n"
                       : "Refused: nothing is written. Record what is missing, or take it with --accept.\n");
  return accept ? 0 : 1;
}

}  // namespace lcmslam
