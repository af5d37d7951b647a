#include <lcmslam/surface/mesh_export.hpp>

#include <stdexcept>
#include <string>

#include <lcmslam/files/atomic_file.hpp>
#include <lcmslam/files/decimal_text.hpp>

static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "the PLY writer copies little-endian numbers");

namespace lcmslam {
namespace {

template <class Number>
void append(std::string& bytes, Number number) {
  bytes.append(reinterpret_cast<const char*>(&number), sizeof number);
}

void append_vector(std::string& bytes, const Eigen::Vector3f& vector) {
  for (const float coordinate : {vector.x(), vector.y(), vector.z()}) append(bytes, coordinate);
}

std::string ply_header(const Mesh& mesh) {
  std::string text =
      "ply\nformat binary_little_endian 1.0\ncomment lcmslam surface, metres, z up\nelement vertex " +
      std::to_string(mesh.vertices.size()) + "\n";
  for (const char* name : {"x", "y", "z", "nx", "ny", "nz"})
    text += std::string("property float ") + name + "\n";
  for (const char* name : {"red", "green", "blue"}) text += std::string("property uchar ") + name + "\n";
  return text + "element face " + std::to_string(mesh.triangles.size()) +
         "\nproperty list uchar int vertex_indices\nend_header\n";
}

}  // namespace

void check_mesh(const Mesh& mesh) {
  const std::size_t size = mesh.vertices.size();
  if (mesh.normals.size() != size || mesh.colours.size() != size)
    throw std::invalid_argument("mesh: " + std::to_string(size) + " vertices have " +
                                std::to_string(mesh.normals.size()) + " normals and " +
                                std::to_string(mesh.colours.size()) + " colours; there must be as many");
  for (const auto& triangle : mesh.triangles)
    for (const std::uint32_t vertex : triangle)
      if (vertex >= size)
        throw std::invalid_argument("mesh: a triangle names vertex " + std::to_string(vertex) + " of " +
                                    std::to_string(size));
}

std::string mesh_ply(const Mesh& mesh) {
  check_mesh(mesh);
  std::string bytes = ply_header(mesh);
  bytes.reserve(bytes.size() + mesh.vertices.size() * 27 + mesh.triangles.size() * 13);
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    append_vector(bytes, mesh.vertices[i]);
    append_vector(bytes, mesh.normals[i]);
    for (const int channel : {2, 1, 0}) append(bytes, mesh.colours[i][channel]);
  }
  for (const auto& triangle : mesh.triangles) {
    append(bytes, std::uint8_t{3});
    for (const std::uint32_t vertex : triangle) append(bytes, static_cast<std::int32_t>(vertex));
  }
  return bytes;
}

void save_mesh_ply(const FilePlace& file, const Mesh& mesh) {
  write_atomically(file, mesh_ply(mesh));
}

void save_mesh_obj(const FilePlace& file, const Mesh& mesh) {
  check_mesh(mesh);
  std::string text = "# lcmslam surface, metres, z up\n";
  const auto add = [&text](const char* key, const Eigen::Vector3d& numbers, int decimals) {
    text += key;
    for (const double number : {numbers.x(), numbers.y(), numbers.z()}) {
      text += ' ';
      append_fixed(text, number, decimals);
    }
  };
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const cv::Vec3b& c = mesh.colours[i];
    add("v", mesh.vertices[i].cast<double>(), 5);
    add("", Eigen::Vector3d(c[2], c[1], c[0]) / 255, 3);
    add("\nvn", mesh.normals[i].cast<double>(), 4);
    text += '\n';
  }
  for (const auto& triangle : mesh.triangles) {
    text += 'f';
    for (const std::uint32_t vertex : triangle) {
      const std::string number = std::to_string(vertex + 1);
      text.append(" ").append(number).append("//").append(number);
    }
    text += '\n';
  }
  write_atomically(file, text);
}

void save_mesh(const FilePlace& file, const Mesh& mesh) {
  const std::string ending = file.path().extension().string();
  if (ending == ".ply") return save_mesh_ply(file, mesh);
  if (ending == ".obj") return save_mesh_obj(file, mesh);
  if (ending == ".glb") return save_mesh_glb(file, mesh);
  throw std::invalid_argument(file.path().string() + ": a mesh is written as .ply, .obj or .glb");
}

}  // namespace lcmslam
