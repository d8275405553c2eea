// What the server makes of bytes beyond decoding them.
#include <opencv2/imgcodecs.hpp>
#include <sstream>

#include "fuzz/target.h"
#include "messages/samples.h"
#include "server/config.h"
#include "server/event_log.h"
#include "server/image_decoder.h"
#include "server/log_contents.h"

namespace eifmap::fuzz {
namespace {

Camera small_camera() {
  Camera camera;
  camera.width = 40;
  camera.height = 32;
  camera.fx = camera.fy = 40;
  camera.cx = 19.5;
  camera.cy = 15.5;
  return camera;
}

// The first byte is the format, the second how much longer a row is than its pixels.
bool decode_all_pixels(Bytes bytes) {
  ByteReader in(bytes);
  ImageMessage image;
  image.format = static_cast<PixelFormat>(in.below(static_cast<int>(PixelFormat::kMjpeg) + 1));
  const Camera camera = small_camera();
  image.width = camera.width;
  image.height = camera.height;
  const int bytes_per_pixel = format_info(image.format).bytes_per_pixel;
  image.row_stride = bytes_per_pixel == 0 ? 0 : image.width * bytes_per_pixel + in.below(9);
  image.data.assign(bytes.begin() + std::min<std::ptrdiff_t>(2, std::ssize(bytes)), bytes.end());
  // As it would have come: decode_image() says which sizes go with which.
  const auto checked = decode_image(encode(to_message(image)));
  if (!checked.ok()) return false;
  const DecodedImage decoded = decode_pixels(checked.value, camera, 8 + in.below(9));
  require(decoded.ok() || !decoded.detail.empty(), "a refusal has words");
  require(!decoded.ok() || (decoded.gray.type() == CV_8UC1 && decoded.gray.cols == camera.width &&
                            decoded.gray.rows == camera.height),
          "pixels are the camera's");
  return decoded.ok();
}

std::vector<Wire> pixels() {
  const cv::Mat gray(32, 40, CV_8UC1, cv::Scalar(77));
  Wire jpeg;
  cv::imencode(".jpg", gray, jpeg);
  std::vector<Wire> wires;
  for (int format = 0; format <= static_cast<int>(PixelFormat::kMjpeg); ++format) {
    Wire wire = {static_cast<std::uint8_t>(format), 0};
    const auto kind = static_cast<PixelFormat>(format);
    if (kind == PixelFormat::kMjpeg)
      wire.insert(wire.end(), jpeg.begin(), jpeg.end());
    else
      wire.resize(2 + 40 * 32 * 4, 99);
    wires.push_back(std::move(wire));
  }
  return wires;
}

bool configure(Bytes bytes) {
  const ParsedConfig parsed = parse_config(text_of(bytes));
  if (!parsed.problem.empty()) return false;
  require(parsed.config.problem().empty(), "a configuration that is read is one");
  require(
      config_text(parse_config(config_text(parsed.config)).config) == config_text(parsed.config),
      "a configuration is the same when it is read again");
  return true;
}

std::vector<Wire> configs() {
  std::vector<Wire> wires = {wire_of(config_text({})), wire_of("{}"),
                             wire_of(R"({"mapper": {"loop": {"enabled": true}}})")};
  ServerConfig config;
  config.calibration = small_camera();
  config.camera = "front";
  wires.push_back(wire_of(config_text(config)));
  return wires;
}

EventLog log_of(Bytes bytes) {
  return {std::make_unique<std::istringstream>(text_of(bytes)), std::ssize(bytes), "log"};
}

bool read_log(Bytes bytes) {
  EventLog log = log_of(bytes);
  std::size_t sum = 0;
  while (log.next()) sum += log.read_message().size() + log.channel().size();
  require(sum <= bytes.size(), "a log holds no more than its bytes");
  const LogContents contents = read_contents(log_of(bytes), "CAMERA", "cam0");
  return contents.problem.empty() && contents.unreadable == 0;
}

void append_event(const std::string& channel, const Wire& message, Wire& log) {
  const auto append = [&log](std::uint64_t value, int size) {
    for (int byte = size - 1; byte >= 0; --byte)
      log.push_back(static_cast<std::uint8_t>(value >> (8 * byte)));
  };
  append(0xeda1da01, 4);
  append(0, 8);
  append(1'700'000'000'000'000, 8);
  append(channel.size(), 4);
  append(message.size(), 4);
  log.insert(log.end(), channel.begin(), channel.end());
  log.insert(log.end(), message.begin(), message.end());
}

std::vector<Wire> logs() {
  Wire log;
  append_event("eifmap.cam0.features", encode(to_message(samples::features(2))), log);
  append_event("eifmap.cam0.image", {1, 2, 3}, log);
  append_event("eifmap.cam0.measurement", encode(to_message(samples::position())), log);
  append_event("eifmap.cam0.pose", encode(to_message(samples::published_pose())), log);
  append_event("eifmap.cam0.decision", encode(to_message(samples::published_decision())), log);
  return {log};
}

}  // namespace

std::vector<Target> server_targets() {
  return {
      {"pixels", &decode_all_pixels, &pixels},
      {"config", &configure, &configs},
      {"event_log", &read_log, &logs},
  };
}

}  // namespace eifmap::fuzz
