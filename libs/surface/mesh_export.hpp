#pragma once
// Meshes as files that MeshLab, Blender, CloudCompare and web pages read.
//
// Every function writes atomically (files/atomic_file.hpp) and throws std::runtime_error that names the file
// and the reason; std::invalid_argument for a mesh whose lists do not fit. Empty meshes give valid files.

#include <lcmslam/files/part_file.hpp>
#include <lcmslam/surface/mesh.hpp>

namespace lcmslam {

/// The bytes of such files, for those who send them.
std::string mesh_ply(const Mesh& mesh);
std::string mesh_glb(const Mesh& mesh);

/// Binary little-endian PLY: x y z nx ny nz red green blue, and faces. z is up, m.
void save_mesh_ply(const FilePlace& file, const Mesh& mesh);

/// Wavefront OBJ: "v x y z r g b" with colours from 0 to 1, "vn", and faces "v//vn". z is up, m.
void save_mesh_obj(const FilePlace& file, const Mesh& mesh);

/// Binary glTF 2.0 with colours of the vertices (linear, as glTF wants them). A node turns z up into glTF's y
/// up.
void save_mesh_glb(const FilePlace& file, const Mesh& mesh);

/// By the file's ending: .ply, .obj or .glb; throws std::invalid_argument for another.
void save_mesh(const FilePlace& file, const Mesh& mesh);

/// Throws std::invalid_argument when lists differ in length or a triangle names a vertex that is not there.
void check_mesh(const Mesh& mesh);

}  // namespace lcmslam
