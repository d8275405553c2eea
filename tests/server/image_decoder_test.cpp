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

cv::Mat two_channels(const cv::Mat& first, const cv::Mat& second) {
  cv::Mat both;
  cv::merge(std::vector{first, second}, both);
  return both;
}

cv::Mat converted(const cv::Mat& image, int code) {
  cv::Mat result;
  cv::cvtColor(image, result, code);
  return result;
}

cv::Mat pixels_in(PixelFormat format, const cv::Mat& color) {
  const cv::Mat gray = converted(color, cv::COLOR_BGR2GRAY);
  const cv::Mat other(gray.size(), CV_8UC1, cv::Scalar(77));  // chroma, or the lower byte
  switch (format) {
    case PixelFormat::kRgb:
      return converted(color, cv::COLOR_BGR2RGB);
    case PixelFormat::kBgr:
      return color;
    case PixelFormat::kRgba:
      return converted(color, cv::COLOR_BGR2RGBA);
    case PixelFormat::kBgra:
      return converted(color, cv::COLOR_BGR2BGRA);
    case PixelFormat::kYuyv:
      return two_channels(gray, other);
    case PixelFormat::kUyvy:
    case PixelFormat::kGray16:
      return two_channels(other, gray);
    default:
      return gray;
  }
}

// An image of `color` in a format, rows padded by `padding` bytes.
ImageMessage in_format(PixelFormat format, const cv::Mat& color, std::size_t padding) {
  const cv::Mat pixels = pixels_in(format, color);
  const std::size_t row = pixels.elemSize() * static_cast<std::size_t>(pixels.cols);
  ImageMessage message;
  message.time_us = 1;
  message.format = format;
  message.width = color.cols;
  message.height = color.rows;
  message.row_stride = static_cast<int>(row + padding);
  for (int y = 0; y < pixels.rows; ++y) {
    message.data.insert(message.data.end(), pixels.ptr(y), pixels.ptr(y) + row);
    message.data.insert(message.data.end(), padding, 0xee);
  }
  return message;
}

cv::Mat colored() {
  cv::Mat image(480, 640, CV_8UC3);
  cv::RNG(2).fill(image, cv::RNG::UNIFORM, 0, 256);
  cv::GaussianBlur(image, image, {0, 0}, 3);
  cv::normalize(image, image, 0, 255, cv::NORM_MINMAX);
  return image;
}

class EveryFormat : public testing::TestWithParam<PixelFormat> {};

// Over the wire, with and without padded rows: the gray image that the color one has.
TEST_P(EveryFormat, GivesTheGrayImage) {
  const cv::Mat gray = converted(colored(), cv::COLOR_BGR2GRAY);
  for (const std::size_t padding : {0, 1, 64}) {
    const Decoded<ImageMessage> message =
        decode_image(encode(to_message(in_format(GetParam(), colored(), padding))));
    ASSERT_TRUE(message.ok()) << message.detail;
    EXPECT_EQ(message.value.format, GetParam());
    const DecodedImage decoded = decode_pixels(message.value, synthetic_camera());
    ASSERT_TRUE(decoded.ok()) << decoded.detail;
    EXPECT_EQ(cv::norm(decoded.gray, gray, cv::NORM_INF), 0) << "padding " << padding;
  }
}

TEST_P(EveryFormat, RowsWithoutAStrideAreNotPadded) {
  bot_core::image_t sent = to_message(in_format(GetParam(), colored(), 0));
  const int stride = sent.row_stride;
  sent.row_stride = 0;
  const Decoded<ImageMessage> message = decode_image(encode(sent));
  ASSERT_TRUE(message.ok()) << message.detail;
  EXPECT_EQ(message.value.row_stride, stride);
}

TEST_P(EveryFormat, AMissingByteIsRefused) {
  bot_core::image_t sent = to_message(in_format(GetParam(), colored(), 0));
  sent.data.pop_back();
  --sent.size;
  const Decoded<ImageMessage> message = decode_image(encode(sent));
  EXPECT_EQ(message.reason, Reason::kBadImageSize);
  EXPECT_NE(message.detail.find(format_info(GetParam()).name), std::string::npos) << message.detail;
}

INSTANTIATE_TEST_SUITE_P(ImageDecoder, EveryFormat,
                         testing::Values(PixelFormat::kGray, PixelFormat::kGray16,
                                         PixelFormat::kRgb, PixelFormat::kBgr, PixelFormat::kRgba,
                                         PixelFormat::kBgra, PixelFormat::kYuyv, PixelFormat::kUyvy,
                                         PixelFormat::kI420, PixelFormat::kNv12),
                         [](const auto& test) {
                           return std::string(format_info(test.param).name);
                         });

TEST(ImageDecoder, Gray16OfACameraWithFewerBits) {
  ImageMessage message = in_format(PixelFormat::kGray16, colored(), 0);
  for (std::size_t pixel = 0; pixel < 640 * 480; ++pixel) {  // 12 bits: 0 to 4095
    message.data[2 * pixel] = static_cast<std::uint8_t>(pixel % 4096 & 255);
    message.data[2 * pixel + 1] = static_cast<std::uint8_t>(pixel % 4096 >> 8);
  }
  const cv::Mat of_12 = decode_pixels(message, synthetic_camera(), 12).gray;
  EXPECT_EQ(of_12.at<std::uint8_t>(0, 160), 160 >> 4);
  EXPECT_EQ(of_12.at<std::uint8_t>(6, 255), 4095 >> 4);
  const cv::Mat of_10 = decode_pixels(message, synthetic_camera(), 10).gray;
  EXPECT_EQ(of_10.at<std::uint8_t>(6, 255), 255) << "too bright is white, not dark again";
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
