#include "client/publisher.h"

#include <algorithm>
#include <opencv2/imgcodecs.hpp>
#include <random>
#include <stdexcept>
#include <thread>

#include "bus/outbox.h"
#include "convert/camera_message.h"
#include "convert/feature_message.h"
#include "convert/feature_parts.h"
#include "convert/image_message.h"
#include "convert/measurement_message.h"
#include "features/front_end.h"
#include "wire/channel.h"
#include "wire/clock.h"

namespace eifmap {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

// A frame's header and some features; a feature a second.
constexpr int kMinMessageBytes = 512, kMinBytesPerS = 1000;

constexpr milliseconds kCalibrationPeriod(1000), kNap(100);

std::int64_t random_publisher() {
  std::random_device device;
  const std::uint64_t bits = (static_cast<std::uint64_t>(device()) << 32) | device();
  return static_cast<std::int64_t>(bits >> 1) | 1;  // positive, never 0
}

using Message = std::vector<std::uint8_t>;

struct Encoded {
  std::vector<Message> messages;
  std::string problem;
};

// One image as the messages that the options ask for.
class FrameEncoder {
 public:
  FrameEncoder(ImageSource& source, const PublishOptions& options, std::int64_t publisher)
      : source_(source), options_(options), publisher_(publisher), extractor_(options.features) {}

  ChannelKind kind() const {
    return options_.as == PublishAs::kFeatures ? ChannelKind::kFeatures : ChannelKind::kImage;
  }

  // In order, each image once: what extracts may follow the camera.
  Encoded encode(int i) {
    switch (options_.as) {
      case PublishAs::kRaw:
        return encode_raw(i);
      case PublishAs::kMjpeg:
        return encode_mjpeg(i);
      case PublishAs::kFeatures:
        return encode_features(i);
    }
    return {{}, "unknown way to publish"};
  }

 private:
  ImageMessage header(int i) const {
    const Camera& camera = source_.camera();
    ImageMessage image;
    image.time_us = source_.time_us(i);
    image.publisher = publisher_;
    image.seq = i;
    image.calibration_id = camera.id();
    image.width = camera.width;
    image.height = camera.height;
    return image;
  }

  Encoded encode_raw(int i) {
    const GrayImage gray = source_.gray(i);
    if (!gray.problem.empty()) return {{}, gray.problem};
    ImageMessage image = header(i);
    image.format = PixelFormat::kGray;
    image.row_stride = gray.image.cols;
    for (int row = 0; row < gray.image.rows; ++row)
      image.data.insert(image.data.end(), gray.image.ptr(row),
                        gray.image.ptr(row) + gray.image.cols);
    return {{eifmap::encode(to_message(image))}, ""};
  }

  Encoded encode_mjpeg(int i) {
    ImageMessage image = header(i);
    image.format = PixelFormat::kMjpeg;
    if (auto file = source_.jpeg(i)) {
      if (!file->problem.empty()) return {{}, file->problem};
      image.data = std::move(file->bytes);
    } else {
      const GrayImage gray = source_.gray(i);
      if (!gray.problem.empty()) return {{}, gray.problem};
      cv::imencode(".jpg", gray.image, image.data,
                   {cv::IMWRITE_JPEG_QUALITY, options_.jpeg_quality});
    }
    return {{eifmap::encode(to_message(image))}, ""};
  }

  Encoded encode_features(int i) {
    const GrayImage gray = source_.gray(i);
    if (!gray.problem.empty()) return {{}, gray.problem};
    const FeatureFrame frame = extract_frame(extractor_, gray.image, source_.camera(),
                                             {source_.time_us(i), publisher_, i, options_.camera});
    if (options_.max_message_bytes == 0) return {{eifmap::encode(to_message(frame))}, ""};
    Encoded parts;
    const auto max_bytes = static_cast<std::size_t>(options_.max_message_bytes);
    for (const feature_frame_t& part : split_features(frame, max_bytes))
      parts.messages.push_back(eifmap::encode(part));
    return parts;
  }

  ImageSource& source_;
  const PublishOptions& options_;
  std::int64_t publisher_;
  FeatureExtractor extractor_;
};

// Sends the calibration whenever its time has come.
class CalibrationBeacon {
 public:
  CalibrationBeacon(const ImageSource& source, const std::string& camera, Bus& bus)
      : source_(source), camera_(camera), bus_(bus) {}

  bool send_if_due() {
    if (Clock::now() < next_) return true;
    next_ = Clock::now() + kCalibrationPeriod;
    const NamedCamera message{now_us(), camera_, source_.camera()};
    return bus_.publish(channel_name(camera_, ChannelKind::kCalibration),
                        encode(to_message(message)));
  }

 private:
  const ImageSource& source_;
  const std::string& camera_;
  Bus& bus_;
  Clock::time_point next_ = Clock::now();
};

// Sends a frame's messages at the pace of the options.
class PacedSender {
 public:
  PacedSender(Bus& bus, std::string channel, int bytes_per_s)
      : bus_(bus),
        channel_(std::move(channel)),
        outbox_(std::max(bytes_per_s, 1)),
        paced_(bytes_per_s > 0) {}

  void push(std::vector<Message> messages) {
    for (Message& message : messages) {
      if (paced_)
        outbox_.push(channel_, std::move(message));
      else
        sent_ &= bus_.publish(channel_, message);
    }
  }

  // What may leave by now does. Returns when the next may, or nothing when none is left.
  std::optional<Clock::time_point> send_due() {
    return outbox_.send_due(Clock::now(), [this](const std::string& channel, const Message& bytes) {
      sent_ &= bus_.publish(channel, bytes);
    });
  }

  bool all_were_sent() const { return sent_; }

 private:
  Bus& bus_;
  std::string channel_;
  Outbox outbox_;
  bool paced_, sent_ = true;
};

// Sends each measurement when an image's time has reached its own.
class MeasurementSender {
 public:
  MeasurementSender(const PublishOptions& options, std::int64_t publisher, Bus& bus)
      : options_(options),
        publisher_(publisher),
        bus_(bus),
        channel_(channel_name(options.camera, ChannelKind::kMeasurement)) {}

  // False when LCM could not send.
  bool send_until(std::int64_t time_us) {
    const std::vector<AbsoluteMeasurement>& all = options_.measurements;
    for (; sent_ < all.size() && usable_from_us(all[sent_]) <= time_us; ++sent_) {
      NamedMeasurement named{options_.camera, all[sent_]};
      named.measurement.id = {publisher_, static_cast<std::int64_t>(sent_)};
      if (!bus_.publish(channel_, eifmap::encode(to_message(named)))) return false;
    }
    return true;
  }
  std::int64_t num_sent() const { return static_cast<std::int64_t>(sent_); }

 private:
  const PublishOptions& options_;
  std::int64_t publisher_;
  Bus& bus_;
  std::string channel_;
  std::size_t sent_ = 0;
};

// When an image is to leave.
class Timetable {
 public:
  Timetable(const ImageSource& source, const PublishOptions& options)
      : rate_hz_(source.live() ? 0 : options.rate_hz), begin_(Clock::now() + options.start_delay) {}

  bool at_once() const { return rate_hz_ == 0; }

  // In order, the first one first.
  Clock::time_point due(int i, std::int64_t time_us) {
    if (i == 0) first_us_ = time_us;
    const double seconds = at_once()      ? 0
                           : rate_hz_ > 0 ? i / rate_hz_
                                          : 1e-6 * static_cast<double>(time_us - first_us_);
    return begin_ +
           std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
  }

 private:
  double rate_hz_;
  Clock::time_point begin_;
  std::int64_t first_us_ = 0;
};

}  // namespace

std::string PublishOptions::problem() const {
  if (!valid_camera_name(camera))
    return "camera is '" + camera + "', wanted 1 to 24 characters of A-Z a-z 0-9 _ -";
  if (jpeg_quality < 1 || jpeg_quality > 100)
    return "JPEG quality is " + std::to_string(jpeg_quality) + ", wanted 1 to 100";
  if (!(rate_hz <= 10000))
    return "rate is " + std::to_string(rate_hz) + ", wanted at most 10000 Hz";
  if (max_message_bytes != 0 && max_message_bytes < kMinMessageBytes)
    return "the largest message is " + std::to_string(max_message_bytes) + " bytes, wanted " +
           std::to_string(kMinMessageBytes) + " or more";
  if (bytes_per_s != 0 && bytes_per_s < kMinBytesPerS)
    return "the pace is " + std::to_string(bytes_per_s) + " bytes a second, wanted " +
           std::to_string(kMinBytesPerS) + " or more";
  if (publisher < 0) return "publisher is " + std::to_string(publisher) + ", wanted 1 or more";
  if (const auto problem = features.problem(); !problem.empty()) return "features." + problem;
  return "";
}

PublishResult publish(ImageSource& source, const PublishOptions& options, Bus& bus,
                      const KeepPublishing& keep_publishing) {
  if (const auto problem = options.problem(); !problem.empty())
    throw std::invalid_argument(problem);
  PublishResult result;
  result.publisher = options.publisher != 0 ? options.publisher : random_publisher();
  FrameEncoder encoder(source, options, result.publisher);
  const std::string channel = channel_name(options.camera, encoder.kind());
  CalibrationBeacon beacon(source, options.camera, bus);
  PacedSender sender(bus, channel,
                     encoder.kind() == ChannelKind::kFeatures ? options.bytes_per_s : 0);
  MeasurementSender measurements(options, result.publisher, bus);
  const std::string unsent = "LCM could not send on " + channel;

  Timetable timetable(source, options);
  const auto wait_until = [&](Clock::time_point due, int i) {
    for (;;) {
      if (!keep_publishing(i)) return false;
      if (!beacon.send_if_due()) result.problem = unsent;
      const auto left = due - Clock::now();
      if (left <= Clock::duration::zero() || !result.problem.empty()) return true;
      std::this_thread::sleep_for(std::min<Clock::duration>(left, kNap));
    }
  };
  for (int i = 0; result.problem.empty(); ++i) {
    if (!keep_publishing(i)) return result;
    if (!source.has(i)) {
      result.problem = source.problem();
      break;
    }
    const auto due = timetable.due(i, source.time_us(i));
    // The image is made before its time, so that making it does not make it late.
    Encoded encoded = encoder.encode(i);
    result.problem = encoded.problem;
    if (!result.problem.empty()) break;
    if (!wait_until(due, i)) return result;
    if (!result.problem.empty()) break;
    for (const Message& message : encoded.messages)
      result.largest_bytes = std::max(result.largest_bytes, message.size());
    result.messages += static_cast<std::int64_t>(encoded.messages.size());
    const auto left = Clock::now();
    if (!measurements.send_until(source.time_us(i))) result.problem = unsent;
    result.measurements = measurements.num_sent();
    sender.push(std::move(encoded.messages));
    for (auto next = sender.send_due(); next && sender.all_were_sent() && result.problem.empty();
         next = sender.send_due())
      if (!wait_until(*next, i)) return result;
    if (!sender.all_were_sent()) result.problem = unsent;
    if (!result.problem.empty()) break;
    ++result.published;
    if (!timetable.at_once())
      result.late_s = std::max(result.late_s, std::chrono::duration<double>(left - due).count());
  }
  keep_publishing(result.published);
  return result;
}

}  // namespace eifmap
