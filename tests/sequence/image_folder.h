// A temporary folder with small images in it.
#pragma once

#include <opencv2/imgcodecs.hpp>
#include <string>

#include "sequence/temporary_folder.h"

namespace eifmap::test {

class ImageFolder : public TemporaryFolder {
 public:
  // A uniform image: its gray tells which one it is.
  std::filesystem::path image(const std::string& name, int gray, int width = 64,
                              int height = 48) const {
    const auto file = path() / name;
    std::filesystem::create_directories(file.parent_path());
    cv::imwrite(file.string(), cv::Mat(height, width, CV_8UC1, cv::Scalar(gray)));
    return file;
  }
};

}  // namespace eifmap::test
