#pragma once

#include <filesystem>

namespace lcmslam {

/// The tree that the tests were built from: config/, logs/ and the like. Its name stands in one object file
/// alone, so that all others are the same in every clone and ccache has them.
std::filesystem::path source_folder();

}  // namespace lcmslam
