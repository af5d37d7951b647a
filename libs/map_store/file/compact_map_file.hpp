#pragma once
// A map file without the room of what is gone.

#include <filesystem>

#include <lcmslam/files/part_file.hpp>

namespace lcmslam {

/// In its place; killed half-way it is as it was. Throws StoreError, also while somebody else has it open.
void compact_map_file(const std::filesystem::path& file);

/// Into a file that is there and empty. Throws StoreError.
void compact_into(const std::filesystem::path& file, const std::filesystem::path& empty);

/// As another file, which is the old one or whole. Throws StoreError, std::runtime_error, also while somebody
/// else has the old one of that name open.
void copy_compacted(const std::filesystem::path& file, const FilePlace& copy);

}  // namespace lcmslam
