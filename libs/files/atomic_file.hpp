#pragma once
// Files that are either the old one or the whole new one, whatever happens in between.

#include <functional>

#include <lcmslam/files/part_file.hpp>

namespace lcmslam {

/// Calls `write` with the path of a part file in the same folder, flushes that to disk and renames it to
/// `file`. On any failure the part file is removed, an existing `file` stays as it was, and
/// std::runtime_error names the file and the reason. What is there already must be a regular file: devices
/// are not replaced, and symbolic links are not followed.
void write_atomically(const FilePlace& file,
                      const std::function<void(const std::filesystem::path& part)>& write);

/// The same for bytes that are already in memory.
void write_atomically(const FilePlace& file, const std::string& bytes);

}  // namespace lcmslam
