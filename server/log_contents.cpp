#include "server/log_contents.h"

#include "convert/feature_message.h"
#include "convert/measurement_message.h"
#include "convert/pose_message.h"

namespace eifmap {
namespace {

// Takes the messages of one log, event by event.
class Reader {
 public:
  void take(EventLog& log, const Channel& channel) {
    switch (channel.kind) {
      case ChannelKind::kImage:
        ++contents_.cameras[channel.camera].frames;
        break;
      case ChannelKind::kFeatures: {
        const std::vector<std::uint8_t> bytes = log.read_message();
        contents_.cameras[channel.camera].frames +=
            !is_part_of_features(bytes) || is_first_part(bytes);
        break;
      }
      case ChannelKind::kMeasurement:
        take_measurement(log.read_message(), channel.camera);
        break;
      case ChannelKind::kDecision:
        take_decision(log.read_message(), channel.camera);
        break;
      case ChannelKind::kPose:
        take_pose(log.read_message(), channel.camera);
        break;
      default:
        break;
    }
  }
  LogContents& contents() { return contents_; }

 private:
  template <class Value>
  bool is_good(const Decoded<Value>& decoded, const std::string& named, const std::string& camera) {
    const bool good = decoded.ok() && named == camera;
    contents_.unreadable += !good;
    return good;
  }

  void take_measurement(std::vector<std::uint8_t> bytes, const std::string& camera) {
    const Decoded<NamedMeasurement> decoded = decode_measurement(bytes);
    if (is_good(decoded, decoded.value.camera, camera))
      contents_.cameras[camera].measurements.emplace(decoded.value.measurement.id,
                                                     std::move(bytes));
  }

  // A datagram may come twice.
  void take_decision(const std::vector<std::uint8_t>& bytes, const std::string& camera) {
    const Decoded<PublishedDecision> decoded = decode_decision(bytes);
    if (!is_good(decoded, decoded.value.origin.camera, camera)) return;
    const auto& [origin, decision] = decoded.value;
    auto& decisions = contents_.cameras[camera].runs[origin.server_epoch].decisions;
    if (decisions.empty() || decisions.back() != decision) decisions.push_back(decision);
  }

  void take_pose(const std::vector<std::uint8_t>& bytes, const std::string& camera) {
    const Decoded<PublishedPose> decoded = decode_pose(bytes);
    if (!is_good(decoded, decoded.value.origin.camera, camera)) return;
    const auto& [origin, pose] = decoded.value;
    contents_.cameras[camera].runs[origin.server_epoch].posed.insert(
        {pose.time_us, pose.publisher, pose.seq});
  }

  LogContents contents_;
};

}  // namespace

std::string in_words(const FrameName& name) {
  return "the frame of " + std::to_string(name.time_us) + " us (publisher " +
         std::to_string(name.publisher) + ", seq " + std::to_string(name.seq) + ")";
}

std::map<std::int64_t, std::int64_t> LogContents::epochs() const {
  std::map<std::int64_t, std::int64_t> counts;
  for (const auto& [name, camera] : cameras)
    for (const auto& [epoch, run] : camera.runs)
      if (!run.decisions.empty()) counts[epoch] += static_cast<std::int64_t>(run.decisions.size());
  return counts;
}

std::optional<Channel> channel_of(const EventLog& log, const std::string& image_channel,
                                  const std::string& camera) {
  if (!image_channel.empty() && log.channel() == image_channel)
    return Channel{camera, ChannelKind::kImage};
  return parse_channel(log.channel());
}

LogContents read_contents(EventLog log, const std::string& image_channel,
                          const std::string& camera) {
  Reader reader;
  while (log.next())
    if (const auto channel = channel_of(log, image_channel, camera)) reader.take(log, *channel);
  reader.contents().problem = log.problem();
  return std::move(reader.contents());
}

}  // namespace eifmap
