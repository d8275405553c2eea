#include "sequence/image_file.h"

#include <algorithm>
#include <cctype>
#include <opencv2/imgcodecs.hpp>

#include "sequence/file_text.h"

namespace eifmap {
namespace fs = std::filesystem;
namespace {

bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

// Takes the digits at `at`, without the zeros that lead them.
std::string_view take_number(std::string_view text, std::size_t& at) {
  while (at + 1 < text.size() && text[at] == '0' && is_digit(text[at + 1])) ++at;
  const std::size_t begin = at;
  while (at < text.size() && is_digit(text[at])) ++at;
  return text.substr(begin, at - begin);
}

}  // namespace

bool is_image(const fs::path& file) {
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  for (const char* known : {".jpg", ".jpeg", ".png", ".pgm", ".ppm", ".bmp", ".tif", ".tiff"})
    if (extension == known) return true;
  return false;
}

std::string list_images(const fs::path& folder, std::vector<fs::path>& images) {
  std::error_code error;
  fs::directory_iterator entry(folder, error);
  if (error) return folder.string() + ": cannot be listed (" + error.message() + ")";
  for (; entry != fs::directory_iterator(); entry.increment(error)) {
    if (error) return folder.string() + ": cannot be listed (" + error.message() + ")";
    if (is_image(entry->path()) && !entry->is_directory(error)) images.push_back(entry->path());
  }
  std::sort(images.begin(), images.end());
  if (images.empty())
    return folder.string() + ": holds no images; wanted files .jpg, .png, .pgm, ...";
  return "";
}

bool natural_less(const std::string& a, const std::string& b) {
  std::size_t i = 0, k = 0;
  while (i < a.size() && k < b.size()) {
    if (is_digit(a[i]) && is_digit(b[k])) {
      const std::string_view x = take_number(a, i), y = take_number(b, k);
      if (x.size() != y.size()) return x.size() < y.size();
      if (x != y) return x < y;
    } else {
      if (a[i] != b[k]) return static_cast<unsigned char>(a[i]) < static_cast<unsigned char>(b[k]);
      ++i, ++k;
    }
  }
  // 7 and 007: equal as numbers, but the order must be the same everywhere.
  if (i == a.size() && k == b.size()) return a < b;
  return i == a.size();
}

FileBytes read_bytes(const fs::path& file) {
  FileBytes result;
  const std::string text = file_text(file).value_or("");
  result.bytes.assign(text.begin(), text.end());
  if (result.bytes.empty())
    result.problem = file.string() + ": cannot be read, or is empty; put the image there again";
  return result;
}

GrayImage read_gray(const fs::path& file) {
  const FileBytes bytes = read_bytes(file);
  if (!bytes.problem.empty()) return {{}, bytes.problem};
  cv::Mat image;
  try {
    // The calibration is of the pixels as stored: a rotation tag must not turn them.
    image = cv::imdecode(bytes.bytes, cv::IMREAD_GRAYSCALE | cv::IMREAD_IGNORE_ORIENTATION);
  } catch (const cv::Exception& e) {
    return {{}, file.string() + ": cannot be decoded (" + e.err + ")"};
  }
  if (image.empty())
    return {{}, file.string() + ": cannot be decoded as an image; put it there again"};
  return {image, ""};
}

}  // namespace eifmap
