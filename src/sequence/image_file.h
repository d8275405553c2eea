// Images as files.
#pragma once

#include <cstdint>
#include <filesystem>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "reason.h"

namespace eifmap {

// A decoded image, or what is wrong with the file.
struct GrayImage {
  cv::Mat image;                          // CV_8UC1; empty when there is a problem
  std::string problem;                    // "" or a sentence
  Reason reason = Reason::kCorruptImage;  // of the problem, or kBadImageSize
};

// A file's bytes as they are, or why they cannot be read.
struct FileBytes {
  std::vector<std::uint8_t> bytes;
  std::string problem;
};

// By its name: .jpg, .png, .pgm, ...
bool is_image(const std::filesystem::path& file);

// The images in a folder, in the order of their names' bytes. Returns "" or what went wrong.
std::string list_images(const std::filesystem::path& folder,
                        std::vector<std::filesystem::path>& images);

// Whether a comes before b as people count: frame9 before frame10.
bool natural_less(const std::string& a, const std::string& b);

FileBytes read_bytes(const std::filesystem::path& file);
GrayImage read_gray(const std::filesystem::path& file);

}  // namespace eifmap
