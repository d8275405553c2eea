// Channel names: eifmap.<camera>.<kind>.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace eifmap {

// LCM carries at most 63 characters of channel name.
inline constexpr std::size_t kMaxCameraName = 24;

// In the place of a camera: the status of a server that has none yet, and commands to a server as a
// whole.
inline constexpr std::string_view kNoCamera = "server";

enum class ChannelKind {
  kImage,
  kFeatures,
  kCalibration,
  kPose,
  kMap,
  kStatus,
  kDecision,
  kMeasurement,
  kRelativeRequest,
  kRelative,
  kMapRequest,
  kCommand,
  kReply
};

struct Channel {
  std::string camera;
  ChannelKind kind = ChannelKind::kImage;
  bool operator==(const Channel&) const = default;
};

// [A-Za-z0-9_-], 1 to 24 characters.
bool valid_camera_name(std::string_view camera);

// Throws std::invalid_argument where it is none.
void require_camera_name(std::string_view camera);

// "", or what is wrong with a message that names another camera than the channel it came on.
std::string camera_problem(std::string_view named, std::string_view channel);

std::string_view to_string(ChannelKind kind);  // "image", "features", ...

// Throws std::invalid_argument on an invalid camera name.
std::string channel_name(std::string_view camera, ChannelKind kind);

// Nothing when `name` is not of this form.
std::optional<Channel> parse_channel(std::string_view name);

// A regular expression, as LCM subscribes by, for one kind of one camera, or of every camera when
// `camera` is empty. Throws std::invalid_argument on an invalid camera name.
std::string channel_pattern(std::string_view camera, ChannelKind kind);

// The regular expression that matches just this name.
std::string literal_pattern(std::string_view name);

}  // namespace eifmap
