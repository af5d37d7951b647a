#include <lcmslam/rendering/animation.hpp>

#include <gtest/gtest.h>

#include <unistd.h>
#include <cstdint>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <sstream>

namespace lcmslam {
namespace {

namespace fs = std::filesystem;

struct Chunk {
  std::string type, data;
};

std::uint32_t number(const std::string& bytes, std::size_t at, std::size_t size = 4) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < size; ++i) value = value << 8 | static_cast<unsigned char>(bytes.at(at + i));
  return value;
}

std::vector<Chunk> chunks_of(const fs::path& file) {
  std::ostringstream text;
  text << std::ifstream(file, std::ios::binary).rdbuf();
  const std::string bytes = text.str();
  std::vector<Chunk> chunks;
  for (std::size_t at = 8; at < bytes.size();) {
    const std::size_t size = number(bytes, at);
    chunks.push_back({bytes.substr(at + 4, 4), bytes.substr(at + 8, size)});
    at += 12 + size;
  }
  return chunks;
}

std::string types_of(const std::vector<Chunk>& chunks) {
  std::string types;
  for (const Chunk& chunk : chunks) types += chunk.type + " ";
  return types;
}

class Animation : public ::testing::Test {
 protected:
  ~Animation() override { fs::remove(file_); }
  /// Noise, so that none is small: several chunks of image data.
  static std::vector<cv::Mat> pictures(int count) {
    std::vector<cv::Mat> all;
    cv::RNG random(3);
    for (int i = 0; i < count; ++i) {
      all.emplace_back(40, 60, CV_8UC3);
      random.fill(all.back(), cv::RNG::UNIFORM, 0, 256);
    }
    return all;
  }
  fs::path file_ = fs::temp_directory_path() / ("lcmslam-animation-" + std::to_string(getpid()) + ".png");
};

TEST_F(Animation, HoldsEveryPictureInItsOrder) {
  const auto all = pictures(3);
  save_animation(FilePlace(file_), all, 0.25);
  const auto chunks = chunks_of(file_);
  EXPECT_EQ(types_of(chunks).substr(0, 20), "IHDR acTL fcTL IDAT ");
  EXPECT_EQ(chunks.back().type, "IEND");
  EXPECT_EQ(number(chunks[1].data, 0), 3U);  // frames
  EXPECT_EQ(number(chunks[1].data, 4), 0U);  // for ever
  std::uint32_t next = 0, frames = 0;
  for (const Chunk& chunk : chunks) {
    if (chunk.type != "fcTL" && chunk.type != "fdAT") continue;
    EXPECT_EQ(number(chunk.data, 0), next++);
    if (chunk.type != "fcTL") continue;
    ++frames;
    EXPECT_EQ(number(chunk.data, 4), 60U);
    EXPECT_EQ(number(chunk.data, 8), 40U);
    EXPECT_EQ(number(chunk.data, 20, 2), 250U);
    EXPECT_EQ(number(chunk.data, 22, 2), 1000U);
  }
  EXPECT_EQ(frames, 3U);
}

// A PNG of a frame's data must be that picture: checked with OpenCV's decoder, which also checks the CRCs.
TEST_F(Animation, EveryFrameDecodesToItsPicture) {
  const auto all = pictures(2);
  save_animation(FilePlace(file_), all, 0.1);
  EXPECT_EQ(cv::norm(cv::imread(file_.string()), all[0], cv::NORM_INF), 0) << "the first is a plain PNG";
  // The second alone: exchange both pictures and compare the image data.
  std::string second;
  for (const Chunk& chunk : chunks_of(file_))
    if (chunk.type == "fdAT") second += chunk.data.substr(4);
  save_animation(FilePlace(file_), {all[1], all[0]}, 0.1);
  std::string alone;
  for (const Chunk& chunk : chunks_of(file_))
    if (chunk.type == "IDAT") alone += chunk.data;
  EXPECT_EQ(second, alone);
  EXPECT_EQ(cv::norm(cv::imread(file_.string()), all[1], cv::NORM_INF), 0);
}

TEST_F(Animation, WhatCannotPlayIsRefused) {
  EXPECT_THROW(save_animation(FilePlace(file_), {}, 0.1), std::invalid_argument);
  EXPECT_THROW(save_animation(FilePlace(file_), pictures(1), 0), std::invalid_argument);
  EXPECT_THROW(save_animation(FilePlace(file_), {cv::Mat(4, 4, CV_8UC3), cv::Mat(5, 4, CV_8UC3)}, 0.1),
               std::invalid_argument);
  EXPECT_FALSE(fs::exists(file_));
}

}  // namespace
}  // namespace lcmslam
