#pragma once
// What every sub-command ends with: the calibration's file, and beside it the file of its covariance.

#include <CLI/CLI.hpp>
#include <filesystem>
#include <optional>
#include <string>

#include <lcmslam/imaging/calibration.hpp>

namespace lcmslam {

struct CalibrationOutput {
  std::string file;    ///< to write
  std::string into;    ///< calibration whose other values stay
  std::string sensor;  ///< name of the head; empty: as it was, or the file's
  bool force = false;
  bool accept = false;  ///< also what was refused

  void add_to(CLI::App& app, const char* what);
  /// To be asked before any work.
  void check() const;
  /// What is not calibrated here: of --into, else of the log, else nothing.
  std::optional<RgbdCalibration> base(const std::optional<RgbdCalibration>& of_input) const;
  /// NAME_covariance.yaml beside NAME.yaml.
  std::filesystem::path covariance_file() const;

  /// Writes both files, each whole or not at all, and says so.
  void write(RgbdCalibration calibration, const std::string& comment, const std::string& covariance) const;
  void write_text(const std::string& text, const std::string& covariance) const;
};

/// Prints what would make a calibration better that is good enough to be used.
void advise(const std::vector<std::string>& wanted);
/// "2 of 3": prints why a set is refused; gives the exit code, 0 where it goes on.
int refuse(const std::vector<std::string>& missing, bool accept);

}  // namespace lcmslam
