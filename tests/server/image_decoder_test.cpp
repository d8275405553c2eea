#include "server/image_decoder.h"

#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "support/feature_world.h"

namespace eifmap {
namespace {

cv::Mat texture() {
  cv::Mat image(480, 640, CV_8UC1);
  cv::RNG(1).fill(image, cv::RNG::UNIFORM, 0, 256);
  cv::GaussianBlur(image, image, {0, 0}, 3);
  return image;
}

ImageMessage jpeg(const cv::Mat& image) {
  ImageMessage message;
  message.width = 640;
  message.height = 480;
  message.format = PixelFormat::kMjpeg;
  cv::imencode(".jpg", image, message.data);
  return message;
}

TEST(ImageDecoder, GrayWithAStride) {
  const cv::Mat image = texture();
  ImageMessage message;
  message.width = 640;
  message.height = 480;
  message.row_stride = 700;
  message.data.assign(700 * 480, 0xee);
  for (int row = 0; row < 480; ++row)
    std::copy_n(image.ptr(row), 640, message.data.begin() + row * 700);
  const DecodedImage decoded = decode_pixels(message, synthetic_camera());
  ASSERT_TRUE(decoded.ok()) << decoded.detail;
  EXPECT_EQ(cv::norm(decoded.gray, image, cv::NORM_INF), 0);
}

TEST(ImageDecoder, JpegAsTheRecordedFolderReadsIt) {
  const ImageMessage message = jpeg(texture());
  const DecodedImage decoded = decode_pixels(message, synthetic_camera());
  ASSERT_TRUE(decoded.ok()) << decoded.detail;
  const cv::Mat expected = cv::imdecode(message.data, cv::IMREAD_GRAYSCALE);
  EXPECT_EQ(cv::norm(decoded.gray, expected, cv::NORM_INF), 0);
}

TEST(ImageDecoder, PaddedJpegIsWhole) {
  ImageMessage message = jpeg(texture());
  message.data.insert(message.data.end(), 100, 0);
  EXPECT_TRUE(decode_pixels(message, synthetic_camera()).ok());
}

TEST(ImageDecoder, SizesThatAreNotTheCalibrations) {
  ImageMessage message = jpeg(texture());
  message.width = 641;
  EXPECT_EQ(decode_pixels(message, synthetic_camera()).reason, Reason::kBadImageSize);
  cv::Mat half;
  cv::resize(texture(), half, {320, 240});
  EXPECT_EQ(decode_pixels(jpeg(half), synthetic_camera()).reason, Reason::kBadImageSize)
      << "the message's fields are right, the JPEG's are not";
}

TEST(ImageDecoder, HugeJpegHeaderIsRefusedUndecoded) {
  ImageMessage message = jpeg(texture());
  for (std::size_t i = 2; i + 9 < message.data.size(); ++i)
    if (message.data[i] == 0xff && message.data[i + 1] == 0xc0)
      std::fill_n(message.data.begin() + static_cast<long>(i) + 5, 4, 0xff);
  const DecodedImage decoded = decode_pixels(message, synthetic_camera());
  EXPECT_EQ(decoded.reason, Reason::kBadImageSize);
  EXPECT_NE(decoded.detail.find("65535x65535"), std::string::npos) << decoded.detail;
}

TEST(ImageDecoder, EveryCutIsRefused) {
  const ImageMessage whole = jpeg(texture());
  for (std::size_t size = 0; size < whole.data.size(); size += 997) {
    ImageMessage cut = whole;
    cut.data.resize(size);
    EXPECT_FALSE(decode_pixels(cut, synthetic_camera()).ok()) << size;
  }
}

TEST(ImageDecoder, DamageNeverGivesAnImageOfAnotherSize) {
  const ImageMessage whole = jpeg(texture());
  cv::RNG random(7);
  for (int trial = 0; trial < 200; ++trial) {
    ImageMessage damaged = whole;
    for (int i = 0; i < 10; ++i)
      damaged.data[static_cast<std::size_t>(random.uniform(0, 700))] =
          static_cast<std::uint8_t>(random.uniform(0, 256));
    const DecodedImage decoded = decode_pixels(damaged, synthetic_camera());
    if (decoded.ok()) {
      EXPECT_EQ(decoded.gray.size(), cv::Size(640, 480));
      EXPECT_EQ(decoded.gray.type(), CV_8UC1);
    } else {
      EXPECT_NE(decoded.detail, "");
    }
  }
}

}  // namespace
}  // namespace eifmap
